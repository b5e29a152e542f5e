// Sources of light.
#pragma once

#include <variant>

#include "geometry/linear.h"

namespace caustic::solver {

struct PointLight {
  geometry::Point position;
  double intensity;  ///< isotropic radiant intensity, W/sr (cd), > 0
};

struct CollimatedLight {
  geometry::Direction direction;  ///< unit vector, the way the light goes
  double irradiance;              ///< across the beam, W/m² (lx), > 0
};

using Light = std::variant<PointLight, CollimatedLight>;

}  // namespace caustic::solver
