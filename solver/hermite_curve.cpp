#include "solver/hermite_curve.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace caustic::solver {

using geometry::Point;
using geometry::Vec3;

namespace {

// So many times as dense as steps places have to be.
constexpr double kDense = 8.0;
// A place that is this share of the gap after it away from the next one tells little.
constexpr double kLeastGap = 0.1;

}  // namespace

std::optional<Point> hermite_curve(std::span<const CurvePlace> known, double ahead) {
  const std::size_t n = known.size();
  assert(n > 0 && n <= kMostCurvePlaces);
  const auto& [origin, axis] = known.front();
  std::array<double, kMostCurvePlaces> xi, run;
  for (std::size_t i = 0; i < n; ++i) {
    xi[i] = axis.dot(known[i].x - origin);
    run[i] = axis.dot(known[i].t);
    if (!(run[i] > 0.0)) return std::nullopt;
  }
  // Lagrange's l_i and its slope at its own place.
  std::array<double, kMostCurvePlaces> lagrange, slope;
  lagrange.fill(1.0);
  slope.fill(0.0);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double inverse = 1.0 / (xi[i] - xi[j]);
      lagrange[i] *= (ahead - xi[j]) * inverse;
      lagrange[j] *= (xi[i] - ahead) * inverse;
      slope[i] += inverse;
      slope[j] -= inverse;
    }
  }
  Point at = origin;
  for (std::size_t i = 0; i < n; ++i) {
    const double square = lagrange[i] * lagrange[i], off = ahead - xi[i];
    at += (square * (1.0 - 2.0 * slope[i] * off)) * (known[i].x - origin) +
          (square * off / run[i]) * known[i].t;
  }
  return at;
}

void PassedPlaces::remember(const CurvePlace& passed, const Point& next) {
  const double gap = (next - passed.x).norm();
  if (count_ > 0 && (passed.x - passed_[0].x).norm() < kLeastGap * gap) count_ = 0;
  passed_[1] = passed_[0];
  passed_[0] = passed;
  count_ = std::min(count_ + 1, passed_.size());
}

Point PassedPlaces::predict(const CurvePlace& last, const CurvePlace& ahead, const Point& dense,
                            double step) const {
  if (count_ < passed_.size()) return dense;
  const double way = last.t.dot(dense - last.x), gap = (passed_[0].x - last.x).norm();
  if (gap < kLeastGap * way || kDense * gap > step) return dense;
  return hermite_curve(std::array{last, ahead, passed_[0], passed_[1]}, way).value_or(dense);
}

}  // namespace caustic::solver
