#include "solver/corrector.h"

#include <cmath>

namespace caustic::solver {

namespace {

// Quadratic convergence doubles the digits each time: from a tenth of the basin six steps reach
// rounding; the rest is for starts far away.
constexpr int kMaxSteps = 12;
// Halvings of a step beyond the end of all paths: near it f ~ A u^(−1/2) − B at a distance u, and
// Newton's step from u to 3u − 2u^(3/2)/u₀^(1/2), u₀ the root, leaves them where u > 9/4 u₀.
constexpr int kStepHalvings = 6;
// Residuals below this many rounding errors of x are as small as they get.
constexpr double kRoundings = 4.0;

}  // namespace

std::optional<FieldPoint> correct(Evaluator& evaluate, const LevelFunction& f, const Point& x,
                                  const CorrectorOptions& options, const Hit* near) {
  const auto at = correct(evaluate, f, evaluate.on_surface(x, near), options);
  return at && (at->x - x).norm() <= options.trust ? at : std::nullopt;
}

std::optional<FieldPoint> correct(Evaluator& evaluate, const LevelFunction& f,
                                  const FieldPoint& start, const CorrectorOptions& options) {
  FieldPoint at = start;
  double previous = geometry::kInfinity;
  for (int i = 0; i < kMaxSteps; ++i) {
    if (!at.finite || (at.x - start.x).norm() > options.trust) return std::nullopt;
    const double residual = f.residual(at);
    const double floor = kRoundings * f.residual_of_rounding(at, evaluate.map().rounding(at.x));
    const Vec3 slope = f.gradient(at);
    const Vec3 step = -(f.value(at) / slope.squaredNorm()) * slope;
    if (residual <= floor) return floor <= kUndetermined ? std::optional(at) : std::nullopt;
    if (residual <= options.residual && step.norm() <= options.position) return at;
    // No progress any more, although close: rounding inside f, not of x, is the limit.
    if (i > 2 && residual >= 0.5 * previous && residual < 1e3 * floor + 1e-9) return at;
    previous = residual;
    if (!step.allFinite()) return std::nullopt;
    FieldPoint next = evaluate.on_surface(at.x + step, at.hits.get());
    for (int k = 1; !next.finite && k <= kStepHalvings; ++k) {
      next = evaluate.on_surface(at.x + std::ldexp(1.0, -k) * step, at.hits.get());
    }
    at = std::move(next);
  }
  return std::nullopt;
}

std::optional<FieldPoint> correct_at_end(Evaluator& evaluate, const LevelFunction& f,
                                         const LevelFunction& end, const Point& x,
                                         const CorrectorOptions& options, const Hit* near) {
  FieldPoint at = evaluate.on_surface(x, near);
  double previous = geometry::kInfinity;
  for (int i = 0; i < kMaxSteps; ++i) {
    if (!at.finite || (at.x - x).norm() > options.trust) return std::nullopt;
    const double rounding = evaluate.map().rounding(at.x), h = end.value(at);
    const double floor = kRoundings * f.residual_of_rounding(at, rounding);
    const bool on_curve = f.residual(at) <= std::max(options.residual, floor);
    // Two equations for the step's coordinates along e1, e2.
    const Vec3 df = f.gradient(at), dh = end.gradient(at);
    geometry::Mat2 K;
    K << df.dot(at.e1), df.dot(at.e2), dh.dot(at.e1), dh.dot(at.e2);
    if (floor > kUndetermined && on_curve) return std::nullopt;
    // Both no better than before, although close: rounding inside f and h is the limit.
    const double merit = f.residual(at) + std::abs(h) / evaluate.map().receiver().width();
    if (i > 2 && merit >= 0.5 * previous && merit < 1e-9 + 1e3 * floor) return at;
    previous = merit;
    if (on_curve && std::abs(h) <= kRoundings * rounding * (1.0 + K.row(1).norm())) return at;
    const Vec2 step = K.inverse() * Vec2(-f.value(at), -h);
    if (!step.allFinite()) return std::nullopt;
    at = evaluate.on_surface(at.x + step.x() * at.e1 + step.y() * at.e2, at.hits.get());
  }
  return std::nullopt;
}

}  // namespace caustic::solver
