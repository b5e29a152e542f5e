// What all subdivisions of surfaces have in common: how large a cell is, and when it is too large
// to see what a light next to it does.
#pragma once

#include "geometry/linear.h"
#include "solver/light.h"

namespace caustic::solver {

/// On curved charts the spread of a cell's corners about its middle underestimates its radius.
constexpr double kRadiusFactor = 1.3;
/// A cell must be smaller than this many distances from a point light, to see σ vary and what it
/// lights.
constexpr double kLightShare = 0.7;

inline bool near_light(const Light& light, const geometry::Point& middle, double radius) {
  const auto* point = std::get_if<PointLight>(&light);
  return point && radius > kLightShare * (middle - point->position).norm();
}

}  // namespace caustic::solver
