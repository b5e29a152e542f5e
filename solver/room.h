// How far a segment of a path may move until a surface that leaves it free hides it, or one that
// hides it lets it pass, to second order. NOTATION.md (S13).
#pragma once

#include <vector>

#include "solver/optical_system.h"

namespace caustic::solver {

/// A straight part of a path.
struct Segment {
  geometry::Ray ray;   ///< t in [0, 1]
  double end;          ///< blocked only before this t
  bool end_moves;      ///< a point light's does not, and a beam's moves with the beginning
  int own;             ///< index of the surface it starts on
  int target = -1;     ///< index of the surface it ends on, if it does
  double begin = 0.0;  ///< and only after this one
};

/// How much of a segment's room a motion of its beginning and of its end uses, 1/m.
struct RoomUse {
  double by_begin = 0.0, by_end = 0.0;

  double total() const { return by_begin + by_end; }
};
RoomUse either(const RoomUse& a, const RoomUse& b);

struct Room {
  bool hidden = false;
  RoomUse use;
};

/// Distance from an aperture's edge, m, < 0 inside.
double margin_of(const std::vector<geometry::Bound>& bounds, const geometry::Point& x);

/// Before one surface, with which the segment has these crossings, ascending, but for the one where
/// it begins or ends on it. `beam`: all of a segment whose end does not move moves with its
/// beginning.
Room room_before(const SystemSurface& surface, int index, const Segment& segment, bool beam,
                 const geometry::RayParameters& crossings);

}  // namespace caustic::solver
