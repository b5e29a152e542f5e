// Whether nothing can hide the light of a whole cell of a first surface, from the light to the cell
// and from there to the receiver, by enclosures along the way. NOTATION.md (S83).
#pragma once

#include "geometry/enclosure.h"
#include "solver/forward_map.h"

namespace caustic::solver {

class ClearWay {
 public:
  explicit ClearWay(const ForwardMap& map);

  /// False if it is not shown. `x` holds the cell, `image` where its light arrives, in space, and
  /// `leaving` the directions in which it goes there, times something positive.
  bool shown(const geometry::IntervalVec3& x, const geometry::IntervalVec3& image,
             const geometry::IntervalVec3& leaving) const;

 private:
  // Straight lines from all of the cell.
  struct Way {
    geometry::IntervalVec3 from, to, along, direction;
  };
  bool misses(const SystemSurface& blocker, const Way& way, const geometry::Interval& part,
              int halvings) const;
  bool misses_all(const Way& way) const;

  const ForwardMap& map_;
};

}  // namespace caustic::solver
