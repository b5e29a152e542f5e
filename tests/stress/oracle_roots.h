// Where a ray meets a surface, by signs at many places of it: no polynomial, no interval.
#pragma once

#include <vector>

#include "tests/stress/oracle_scene.h"

namespace caustic::stress {

/// Part of a line, w a unit vector.
struct Stretch {
  LongVec o, w;
  Long t0, t1;
};

/// Increasing, where the surface exists, give or take `slack`. `size` of the scene.
std::vector<Long> surface_roots(const OracleSurface& surface, const Stretch& ray, double size,
                                Long slack = 0.0L);

}  // namespace caustic::stress
