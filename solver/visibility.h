// What surfaces hide: the way from the light to the first surface (shadow), from each surface to the
// next and from the last to the receiver (occlusion), by any surface, those of the path included.
// Decided in double precision on the exact surfaces; Embree proposes candidates where there are many.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "geometry/embree_scene.h"
#include "solver/contours.h"
#include "solver/forward_map.h"

namespace caustic::solver {

/// Many surfaces or few: below this number asking each is faster than Embree (tests/bench).
constexpr int kEmbreeSurfaces = 8;

/// Where light goes: its hits and its arrival on the receiver.
struct LightPath {
  std::array<Point, kMaxHops + 1> at;
  int count = 0;

  /// `hits` as in FieldPoint.
  LightPath(const ForwardMap& map, const Point& x, const Hit* hits, const Point& p);
  LightPath(const ForwardMap& map, const FieldPoint& f)
      : LightPath(map, f.x, f.hits.get(), map.receiver().point(f.q)) {}
  const Point& x() const { return at[0]; }
  /// How far any of its points moves at most to another path of the family.
  double motion(const LightPath& other) const;
};

class Visibility {
 public:
  /// `candidates` may be null: then every surface is asked. Surfaces whose box is further away than
  /// `margin` (m) count as that far.
  Visibility(const OpticalSystem& system, const geometry::EmbreeScene* candidates, double margin);

  /// Signed clearance (S13), m: > 0 if all segments are free, and then how far the nearest blocker
  /// is; < 0 if one is hidden, and then how far the nearest way out is. `ending` says which segment.
  struct Sight {
    double clearance;
    Ending ending;
  };
  Sight look(const Hops& hops, const LightPath& path) const;
  bool hidden(const Hops& hops, const LightPath& path) const {
    return look(hops, path).clearance < 0.0;
  }

 private:
  struct Segment {
    geometry::Ray ray;  // t in [0, 1]
    double end;         // blocked only before this t
    bool end_moves;     // a light's does not
    int own;            // index of the surface it starts on
    int target = -1;    // index of the surface it ends on, if it does
  };
  double clearance(const Segment& segment) const;
  double clearance(const Segment& segment, int surface) const;

  const OpticalSystem& system_;
  const geometry::EmbreeScene* candidates_;
  double margin_;
};

}  // namespace caustic::solver
