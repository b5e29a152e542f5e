// How far a polyline is from the curve that it stands for.
#pragma once

#include <algorithm>
#include <cmath>

#include "geometry/linear.h"

namespace caustic::solver {

/// Largest distance from its chord of the cubic from a to b with velocities da, db over the unit
/// interval, at three places.
inline double chord_error(const geometry::Vec2& a, const geometry::Vec2& b,
                          const geometry::Vec2& da, const geometry::Vec2& db) {
  const geometry::Vec2 chord = b - a;
  const double length2 = chord.squaredNorm(), inverse = length2 > 0.0 ? 1.0 / length2 : 0.0;
  double worst = 0.0;
  for (const double w : {0.25, 0.5, 0.75}) {
    const double v = 1.0 - w;
    const geometry::Vec2 q =
        (w * w * (3.0 - 2.0 * w)) * chord + (w * v * v) * da - (w * w * v) * db;
    const double along = std::clamp(q.dot(chord) * inverse, 0.0, 1.0);
    worst = std::max(worst, (q - along * chord).squaredNorm());
  }
  return std::sqrt(worst);
}

}  // namespace caustic::solver
