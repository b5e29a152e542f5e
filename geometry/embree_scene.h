// Which boxes does a segment meet? Embree's hierarchy over bounding boxes, in single precision and
// rounded outwards: it proposes candidates, the exact surfaces decide.
#pragma once

#include <memory>
#include <vector>

#include "geometry/linear.h"

namespace caustic::geometry {

class EmbreeScene {
 public:
  /// Boxes may be infinite; `margin` (m) is added on every side.
  EmbreeScene(const std::vector<Box>& boxes, double margin);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  /// Indices of all boxes that the segment ray(0…t1) meets, ascending, and of some that it does not.
  /// Thread-safe.
  void candidates(const Ray& ray, double t1, std::vector<int>& out) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace caustic::geometry
