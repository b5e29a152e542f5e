// What is known of some scenes without tracing anything.
#pragma once

#include "geometry/linear.h"

namespace caustic::bench {

/// Scene A1, a unit ball at 0 under a lamp of 1 W/sr at (0, 0, 4): the circle of this level on the
/// ceiling z = 6. E falls from the axis outwards.
double circle_of_a_ball(double level);

/// Scene B: the unit cylinder's arc |φ| ≤ 60°, 0 ≤ z ≤ 1, in a beam along (1, 0, −1). From
/// x(φ) = (cos φ, sin φ) at height t light comes to
///
///     q = x(φ) − t (cos 2φ, sin 2φ),   E = (cos φ/√2)/|cos φ − 2t|
///
/// so that the sheets at q are the zeros of q₁ sin 2φ − q₂ cos 2φ − sin φ.
class NephroidRing {
 public:
  double irradiance(const geometry::Vec2& q) const;
  double distance_from_caustic(const geometry::Vec2& q) const;
  double distance_from_edges(const geometry::Vec2& q) const;
};

}  // namespace caustic::bench
