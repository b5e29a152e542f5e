#include "geometry/expression/expression_bound.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace caustic::geometry {

namespace {

// Median of the finite, positive numbers; 0 if there are none.
double median(std::vector<double> of) {
  std::erase_if(of, [](double x) { return !(x > 0.0 && std::isfinite(x)); });
  if (of.empty()) return 0.0;
  const auto middle = of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2);
  std::nth_element(of.begin(), middle, of.end());
  return *middle;
}

// |∇f| where random lines of all sizes about the origin pass through the zero set; where they pass
// if none does.
double typical_slope(const Field& f, double scale) {
  constexpr int kLines = 24, kSteps = 32;
  std::mt19937_64 engine(1);  // the same on every machine, as no distribution of the library is
  const auto coordinate = [&](double half) {
    return half * (static_cast<double>(engine() >> 11) * 0x1p-52 - 1.0);
  };
  const auto point = [&](double half) {
    const double x = coordinate(half), y = coordinate(half), z = coordinate(half);
    return Point(x, y, z);
  };
  std::vector<double> on_zero, anywhere;
  for (double half = 0.01 * scale; half < 2e3 * scale; half *= 10.0) {
    for (int line = 0; line < kLines; ++line) {
      const Point a = point(half), b = point(half);
      double before = 0.0;
      for (int i = 0; i <= kSteps; ++i) {
        const Point x = a + (b - a) * (static_cast<double>(i) / kSteps);
        Vec3 gradient;
        const double here = f.value_gradient(x, gradient);
        if (i > 0 && ((before < 0.0 && here > 0.0) || (before > 0.0 && here < 0.0))) {
          const Point root = x + (a - b) * (here / (here - before) / kSteps);
          Vec3 slope;
          f.value_gradient(root, slope);
          on_zero.push_back(slope.norm());
        }
        anywhere.push_back(gradient.norm());
        before = here;
      }
    }
  }
  const double typical = median(std::move(on_zero));
  if (typical > 0.0) return typical;
  const double fallback = median(std::move(anywhere));
  return fallback > 0.0 ? fallback : 1.0;
}

}  // namespace

ExpressionBound::ExpressionBound(const Expression& expression, double scale)
    : f_(expression, 1.0), typical_(typical_slope(f_, scale)) {}

double ExpressionBound::value(const Point& x) const {
  Vec3 slope;
  const double f = f_.value_gradient(x, slope);
  const double h = f / std::sqrt(typical_ * typical_ + slope.squaredNorm());
  return std::isnan(h) ? kInfinity : h;
}

// ∇h = ∇f/N − f H∇f/N³ with N² = G² + |∇f|².
Vec3 ExpressionBound::gradient(const Point& x) const {
  Vec3 slope;
  Mat3 hessian;
  const double f = f_.derivatives(x, slope, hessian);
  const double n2 = typical_ * typical_ + slope.squaredNorm();
  const Vec3 gradient = (slope - hessian * slope * (f / n2)) / std::sqrt(n2);
  return gradient.allFinite() ? gradient : Vec3::Zero();
}

Interval ExpressionBound::range(const Box& box) const {
  Interval f;
  IntervalVec3 slope;
  const IntervalVec3 x = intervals(box);
  const bool defined = f_.enclose(x, f, slope);
  if (defined) {  // (S17)
    const Point c = box.center();
    Interval mean;
    f_.enclose(intervals(c), mean);
    const IntervalVec3 d = x - c;
    for (int k = 0; k < 3; ++k) mean += slope[k] * d[k];
    f = intersection(f, mean);
  }
  const Interval h = f / sqrt(sqr(typical_) + squared_norm(slope));
  if (h.empty()) return f.empty() ? Interval(kInfinity) : Interval::whole();
  return defined ? h : Interval(h.lo, kInfinity);
}

}  // namespace caustic::geometry
