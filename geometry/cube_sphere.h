// The unit sphere as six faces of a cube, with nearly equal cells.
#pragma once

#include <cmath>

#include "geometry/linear.h"

namespace caustic::geometry {

/// Face 0…5 (±x, ±y, ±z), (s, t) in [0,1]² → a unit vector. Equiangular: tan(π/4·(2s − 1)).
inline Direction cube_sphere(int face, double s, double t) {
  const double a = std::tan(0.25 * kPi * (2.0 * s - 1.0));
  const double b = std::tan(0.25 * kPi * (2.0 * t - 1.0));
  const int axis = face / 2;
  Vec3 d;
  d[axis] = face % 2 == 0 ? 1.0 : -1.0;
  d[(axis + 1) % 3] = a;
  d[(axis + 2) % 3] = b;
  return d.normalized();
}

}  // namespace caustic::geometry
