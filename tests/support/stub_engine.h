// An engine that draws circles: enough to test what lies around it.
#pragma once

#include <cmath>

#include "solver/contours.h"

namespace caustic::test {

/// A closed circle for each level and one open caustic.
inline solver::ContourResult draw_circles(const solver::OpticalSystem& system,
                                          const solver::ContourRequest& request) {
  solver::ContourResult result;
  result.families = {{0, {0}, 0.42}};
  result.levels = request.levels.values.empty() ? std::vector{0.1, 0.2} : request.levels.values;
  result.skipped = {{"visibility", "one convex surface, nothing else to hit"}};
  const double largest = system.receiver().half.minCoeff();
  const int n = 64;
  for (std::size_t i = 0; i <= result.levels.size(); ++i) {
    const bool caustic = i == result.levels.size();
    const double radius = largest / static_cast<double>(i + 2);
    const double step = 2 * radius * std::sin(geometry::kPi / n);
    solver::Curve curve;
    curve.kind = caustic ? solver::CurveKind::caustic : solver::CurveKind::isolux;
    curve.level = caustic ? -1.0 : result.levels[i];
    curve.parity = caustic ? 0 : 1;
    curve.closed = !caustic;
    if (caustic) curve.ends = {solver::Ending::aperture, solver::Ending::receiver_edge};
    for (int k = 0; k < n; ++k) {
      const double angle = 2 * geometry::kPi * k / n;
      const geometry::Vec2 uv(radius * std::cos(angle), radius * std::sin(angle));
      const geometry::Vec3 gradient = caustic ? geometry::Vec3::Zero() : geometry::Vec3(1, 2, 3);
      curve.vertices.push_back(
          {uv, system.receiver().point(uv), {0, 0, 1}, curve.level, 1e-12, gradient, k * step});
    }
    curve.length = (caustic ? n - 1 : n) * step;
    curve.max_residual = 1e-12;
    result.curves.push_back(curve);
  }
  result.evaluations = 1234;
  result.seconds = 0.001;
  return result;
}

}  // namespace caustic::test
