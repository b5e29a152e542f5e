// A curve next to places of it that are known (S86). What a step's dense output misses is below
// what Newton's method needs; what this misses, where vertices are close to each other, is below
// what it leaves.
#pragma once

#include <array>
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

/// What a curve that is being traced has passed.
class PassedPlaces {
 public:
  void clear() { count_ = 0; }
  /// `passed` is the last place no longer: `next` is.
  void remember(const CurvePlace& passed, const geometry::Point& next);
  /// Where the curve is between its last place and one ahead of that, at `dense` by the dense
  /// output of a step of this length, m: that itself, unless the places passed are so close to each
  /// other that they tell it better.
  geometry::Point predict(const CurvePlace& last, const CurvePlace& ahead,
                          const geometry::Point& dense, double step) const;

 private:
  std::array<CurvePlace, kMostCurvePlaces - 2> passed_;  // the last one first
  std::size_t count_ = 0;
};

}  // namespace caustic::solver
