// How far a point of the receiver is from a curve.
#pragma once

#include <algorithm>

#include "solver/contours.h"

namespace caustic::test {

/// From `q` to the polyline; infinite if it has no segment.
inline double distance_to(const solver::Curve& curve, const geometry::Vec2& q) {
  const std::size_t n = curve.vertices.size();
  double least = geometry::kInfinity;
  for (std::size_t i = 0; i + (curve.closed ? 0 : 1) < n; ++i) {
    const geometry::Vec2 &a = curve.vertices[i].uv, chord = curve.vertices[(i + 1) % n].uv - a;
    const double length2 = chord.squaredNorm();
    const double w = length2 > 0.0 ? std::clamp((q - a).dot(chord) / length2, 0.0, 1.0) : 0.0;
    least = std::min(least, (a + w * chord - q).norm());
  }
  return least;
}

}  // namespace caustic::test
