// 2: [C] §4.2.4 as published, on the irradiance of NOTATION.md (S7) instead of her (4.20). Her
// names are in the comments. What she leaves open is given for nothing: a start on each curve, with
// its path.
#include <cmath>
#include <optional>

#include "solver/find_paths.h"
#include "solver/forward_map.h"
#include "tests/bench/methods/method.h"

namespace caustic::bench {

using geometry::Point;
using geometry::Vec2;
using solver::FieldPoint;

namespace {

enum class Predictor { euler, milne };

// ε of her corrector, |φ/φ₀ − 1|, and when it is said not to converge.
constexpr double kEpsilon = 1e-10;
constexpr int kCorrections = 20;
// Halvings of a step after which she sees no progress, and the longest curve, widths of the window.
constexpr int kHalvings = 20;
constexpr double kLongest = 20.0;

enum class End { closed, left, stuck, endless };

class Contour {
 public:
  Contour(const Scene& scene, const Seed& seed, Predictor predictor, double step)
      : scene_(scene),
        map_(scene.system, 0, side_of(scene, seed.x)),
        level_(scene.levels[seed.level]),
        step_(step),
        predictor_(predictor),
        convex_(map_.shape().convex(map_.side())),
        start_(map_.evaluate(seed.x)) {}

  /// Both ways from the start, unless the first comes back to it.
  test::Line draw() {
    test::Line line = trace(1.0);
    if (end_ == End::closed) return line;
    stuck_ = end_ == End::stuck || end_ == End::endless;
    const test::Line back = trace(-1.0);
    stuck_ = stuck_ || end_ == End::stuck || end_ == End::endless;
    test::Line whole(back.rbegin(), back.rend());
    whole.insert(whole.end(), line.begin() + 1, line.end());
    return whole;
  }
  bool stuck() const { return stuck_; }
  std::uint64_t evaluations() const { return evaluations_; }

 private:
  static int side_of(const Scene& scene, const Point& x) {
    const solver::ForwardMap map(scene.system, 0, 1);
    return map.evaluate(x).lit() ? 1 : -1;
  }

  // ProjectToSurface, TraceRay. Nothing where the path is not valid (her Fig. 4.7).
  std::optional<FieldPoint> cast(const Point& x) {
    ++evaluations_;
    FieldPoint f = map_.evaluate(map_.project(x));
    if (!f.arrives() || !f.lit() || (f.a > 0.0) != (start_.a > 0.0)) return std::nullopt;
    if (!geometry::exists_at(map_.mirror().bounds, f.x) || hidden(f)) return std::nullopt;
    return f;
  }

  bool hidden(const FieldPoint& f) const {
    if (convex_) return false;
    const auto& system = scene_.system;
    const auto* lamp = std::get_if<solver::PointLight>(&system.light());
    const Point from =
        lamp ? lamp->position : Point(f.x - 2.0 * system.diameter() * map_.incident(f.x));
    return solver::segment_hidden(system, from, -1, f.x, 0) ||
           solver::segment_hidden(system, f.x, 0, system.receiver().point(f.q), -1);
  }

  // The gradient rotated by −π/2, to length 1.
  Vec2 tangent(const FieldPoint& f) const {
    const Vec2 g = f.irradiance_gradient();
    return direction_ * Vec2(g.y(), -g.x()).normalized();
  }

  // Predictor: x′ = x + JΔp.
  std::optional<FieldPoint> predict(const FieldPoint& f, const test::Line& line, double h) {
    const std::size_t n = line.size();
    Vec2 dp = h * tangent(f);
    if (predictor_ == Predictor::milne && even_steps_ >= 3 && h == step_) {
      const Vec2 sum = 2.0 * tangents_[n - 3] - tangents_[n - 2] + 2.0 * tangents_[n - 1];
      dp = line[n - 4] + 4.0 * h / 3.0 * sum - f.q;
    }
    return cast(f.x + f.pull_back(dp));
  }

  // Corrector, by |∇φ|² as in her pseudo-code.
  std::optional<FieldPoint> correct(std::optional<FieldPoint> f) {
    for (int i = 0; f && i < kCorrections; ++i) {
      const double E = f->irradiance();
      if (std::abs(E / level_ - 1.0) <= kEpsilon) return f;
      const Vec2 g = f->irradiance_gradient();
      f = cast(f->x + f->pull_back((level_ - E) * g / g.squaredNorm()));
    }
    return std::nullopt;
  }

  // Where the segment leaves the window.
  Vec2 clipped(const Vec2& inside, const Vec2& outside) const {
    const Vec2 half = scene_.system.receiver().half;
    double t = 1.0;
    for (int i = 0; i < 2; ++i) {
      const double reach = std::copysign(half[i], outside[i]);
      if (std::abs(outside[i]) > half[i])
        t = std::min(t, (reach - inside[i]) / (outside[i] - inside[i]));
    }
    return inside + t * (outside - inside);
  }

  bool passes_start(const test::Line& line) const {
    const Vec2 along = line.back() - line[line.size() - 2],
               to = line.front() - line[line.size() - 2];
    const double t = to.dot(along) / along.squaredNorm();
    return line.size() > 3 && t > 0.0 && t <= 1.0 && (to - t * along).norm() < 0.5 * along.norm();
  }

  test::Line trace(double direction) {
    direction_ = direction;
    even_steps_ = 0;
    FieldPoint f = start_;
    test::Line line{f.q};
    tangents_ = {tangent(f)};
    while (static_cast<double>(line.size()) * step_ < kLongest * scene_.width()) {
      std::optional<FieldPoint> next;
      double h = step_;
      for (int i = 0; i < kHalvings; ++i, h *= 0.5)
        if ((next = correct(predict(f, line, h)))) break;
      if (!next) return end_ = End::stuck, line;
      if (!scene_.system.receiver().contains(next->q)) {
        line.push_back(clipped(f.q, next->q));
        return end_ = End::left, line;
      }
      even_steps_ = h == step_ ? even_steps_ + 1 : 0;
      f = *next;
      line.push_back(f.q);
      tangents_.push_back(tangent(f));
      if (passes_start(line)) {
        line.back() = line.front();
        return end_ = End::closed, line;
      }
    }
    return end_ = End::endless, line;
  }

  const Scene& scene_;
  solver::ForwardMap map_;
  double level_, step_;
  Predictor predictor_;
  bool convex_;
  FieldPoint start_;
  std::vector<Vec2> tangents_;
  double direction_ = 1.0;
  int even_steps_ = 0;
  std::uint64_t evaluations_ = 0;
  End end_ = End::closed;
  bool stuck_ = false;
};

Drawing draw_chen(const Scene& scene, Predictor predictor, double step) {
  Drawing drawing{std::vector<std::vector<test::Line>>(scene.levels.size()), 0, ""};
  int stuck = 0;
  for (const Seed& seed : scene.seeds) {
    Contour contour(scene, seed, predictor, step * scene.width());
    drawing.levels[seed.level].push_back(contour.draw());
    drawing.evaluations += contour.evaluations();
    stuck += contour.stuck();
  }
  if (stuck > 0)
    drawing.remark =
        std::to_string(stuck) + " of " + std::to_string(scene.seeds.size()) + " curves stuck";
  return drawing;
}

}  // namespace

std::vector<Method> chen_methods() {
  const std::vector<double> steps{3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5};
  const auto method = [&](const char* name, Predictor predictor) {
    return Method{name, solver::Measure::sheet, steps, [=](const Scene& scene, double step) {
                    return draw_chen(scene, predictor, step);
                  }};
  };
  return {method("Chen, Euler", Predictor::euler), method("Chen, Milne", Predictor::milne)};
}

}  // namespace caustic::bench
