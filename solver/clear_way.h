// Whether anything hides the light of a whole cell of a first surface, from the light to the cell
// and from there to the receiver, by enclosures along the way. NOTATION.md (S83).
#pragma once

#include "geometry/enclosure.h"
#include "solver/forward_map.h"

namespace caustic::solver {

/// Of all light of a cell: nothing hides it, something hides it, neither is shown.
enum class Passage { clear, hidden, unknown };

class ClearWay {
 public:
  explicit ClearWay(const ForwardMap& map);

  /// `x` holds the cell, `image` where its light arrives, in space, and `leaving` the directions in
  /// which it goes there, times something positive.
  Passage passage(const geometry::IntervalVec3& x, const geometry::IntervalVec3& image,
                  const geometry::IntervalVec3& leaving) const;

 private:
  // Straight lines from all of the cell.
  struct Way {
    geometry::IntervalVec3 from, to, along, direction;
    int side;  // of the first surface, by the sign of g
    geometry::IntervalVec3 over(const geometry::Interval& part) const;
  };
  bool leaves_mirror(const Way& way) const;
  bool misses(const SystemSurface& blocker, const Way& way, const geometry::Interval& part,
              int halvings) const;
  bool crosses(const SystemSurface& blocker, const Way& way, const geometry::Interval& part,
               int sign_before, int sign_behind, int halvings) const;
  Passage passage(const Way& way) const;

  const ForwardMap& map_;
};

}  // namespace caustic::solver
