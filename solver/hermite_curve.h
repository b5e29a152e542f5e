// A curve next to places of it that are known (S86). What a step's dense output misses is below
// what Newton's method needs; what this misses, where vertices are close to each other, is below
// what it leaves.
#pragma once

#include <optional>
#include <span>

#include "geometry/linear.h"

namespace caustic::solver {

struct CurvePlace {
  geometry::Point x;
  geometry::Vec3 t;  ///< unit tangent
};

/// At most so many places are made use of.
constexpr std::size_t kMostCurvePlaces = 4;

/// The curve's place `ahead`, m, of the first along that one's tangent; nothing where the curve
/// turns by a right angle towards one of the others.
std::optional<geometry::Point> hermite_curve(std::span<const CurvePlace> known, double ahead);

}  // namespace caustic::solver
