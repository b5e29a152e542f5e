// What surfaces hide: the way from the light to the mirror (shadow) and from the mirror to the receiver
// (occlusion), by any surface, the mirror itself included. Decided in double precision on the exact
// surfaces; Embree proposes candidates where there are many.
#pragma once

#include <memory>
#include <vector>

#include "geometry/embree_scene.h"
#include "solver/contours.h"
#include "solver/optical_system.h"

namespace caustic::solver {

/// Many surfaces or few: below this number asking each is faster than Embree (tests/bench).
constexpr int kEmbreeSurfaces = 8;

class Visibility {
 public:
  /// `candidates` may be null: then every surface is asked. Surfaces whose box is further away than
  /// `margin` (m) count as that far.
  Visibility(const OpticalSystem& system, const geometry::EmbreeScene* candidates, double margin);

  /// Signed clearance (S13), m: > 0 if both segments are free, and then how far the nearest blocker
  /// is; < 0 if one is hidden, and then how far the nearest way out is. `ending` says which segment.
  struct Sight {
    double clearance;
    Ending ending;
  };
  /// At x on the mirror `surface`, with p on the receiver.
  Sight look(int surface, const Point& x, const Point& p) const;
  bool hidden(int surface, const Point& x, const Point& p) const {
    return look(surface, x, p).clearance < 0.0;
  }

 private:
  struct Segment {
    geometry::Ray ray;  // from the mirror; t in [0, 1]
    double end;         // blocked only before this t
    bool end_moves;     // the receiver's end does, a light's does not
    int own;            // index of the surface it starts on
  };
  double clearance(const Segment& segment) const;
  double clearance(const Segment& segment, int surface) const;

  const OpticalSystem& system_;
  const geometry::EmbreeScene* candidates_;
  double margin_;
};

}  // namespace caustic::solver
