#include "solver/seeding.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_set>

#include "geometry/root_finding.h"

namespace caustic::solver {

namespace {

// φ is infinite on the silhouette; flux below this share of what falls on the mirror's face there
// is rounding.
constexpr double kDarkCosine = 1e-9;
// A seed is good enough for Newton's method when f is down to this share of its values at the ends.
constexpr double kSeedShare = 0.1;
constexpr double kFlatShare = 0.05;
// A seed is on a boundary within this share of its cell; Newton's method gets there in some steps.
constexpr double kBoundaryShare = 1e-3;
constexpr int kBoundarySteps = 3;
// A component of a gradient this small against its spread over a cell may be zero in it.
constexpr double kCornerShare = 1e-3;

double phi(const FieldPoint& f) {
  if (f.cos_alpha <= kDarkCosine) return std::copysign(geometry::kInfinity, f.a);
  return f.inverse_irradiance();
}

class Seeder {
 public:
  Seeder(Evaluator& evaluate, Exploration& e, const std::vector<LevelFunction>& targets)
      : evaluate_(evaluate), domain_(evaluate.map()), e_(e), targets_(targets) {}

  // The edge between two corners of one chart, also where a level is crossed twice.
  void edge(const Cell& cell, const Corner& a, const Corner& b) {
    if (!fresh(a.sample, b.sample)) return;
    const auto turn = turning_point(a, b);
    if (!turn) return span(cell, a, b);
    const Corner c{a.s + *turn * (b.s - a.s), a.t + *turn * (b.t - a.t),
                   static_cast<int>(e_.samples.size()), a.boundary};
    e_.samples.push_back(place(cell, a, b, *turn));
    span(cell, a, c);
    span(cell, c, b);
  }
  // The straight line through space from a critical point to a corner, projected on the surface.
  void spoke(const Cell& cell, const FieldPoint& from, const FieldPoint& to) {
    crossings(phi(from), phi(to), [&](int target) {
      root(target, from, to, cell, [&](double w) {
        return evaluate_.on_surface(from.x + w * (to.x - from.x), from.hits.get());
      });
    });
  }

  std::vector<Seed> seeds;

 private:
  bool fresh(int a, int b) {
    const auto lo = static_cast<std::uint64_t>(std::min(a, b));
    const auto hi = static_cast<std::uint64_t>(std::max(a, b));
    return seen_.insert((hi << 32) | lo).second;
  }

  template <class Action>
  void crossings(double from, double to, const Action& action) const {
    const auto [lo, hi] = std::minmax(from, to);
    if (!(lo < hi)) return;
    const auto below = [](const LevelFunction& f, double value) { return f.k < value; };
    auto it = std::lower_bound(targets_.begin(), targets_.end(), lo, below);
    for (; it != targets_.end() && it->k < hi; ++it) {
      action(static_cast<int>(it - targets_.begin()));
    }
  }

  void span(const Cell& cell, const Corner& a, const Corner& b) {
    const double from = phi(e_.samples[a.sample]), to = phi(e_.samples[b.sample]);
    crossings(from, to, [&](int target) {
      root(target, e_.samples[a.sample], e_.samples[b.sample], cell,
           [&](double w) { return place(cell, a, b, w); });
    });
  }

  // Between two corners. Where the edge is a chord of the domain's boundary, on that: levels cross
  // a boundary between two corners on it, but the chord perhaps outside. Not so on the silhouette,
  // which no level crosses (S9).
  FieldPoint place(const Cell& cell, const Corner& a, const Corner& b, double w) {
    const double s = a.s + w * (b.s - a.s), t = a.t + w * (b.t - a.t);
    FieldPoint at = evaluate_(e_.charts[cell.chart].point(s, t));
    const bool on_boundary = a.boundary >= 0 && a.boundary != domain_.silhouette();
    for (int k = 0; on_boundary && at.finite && k < kBoundarySteps; ++k) {
      Vec3 slope = domain_.gradient(a.boundary, at);
      slope -= at.n * at.n.dot(slope);
      const Vec3 step = -(domain_.value(a.boundary, at) / slope.squaredNorm()) * slope;
      const double length = step.norm();
      if (!(length > kBoundaryShare * cell.radius && length < cell.radius)) break;
      at = evaluate_.on_surface(at.x + step, at.hits.get());
    }
    return at;
  }

  // Where f changes sign between two samples along `path`, w in [0, 1].
  template <class Path>
  void root(int target, const FieldPoint& a, const FieldPoint& b, const Cell& cell,
            const Path& path) {
    const LevelFunction& f = targets_[target];
    const double fa = f.value(a), fb = f.value(b);
    FieldPoint at = fa == 0.0 ? a : b;
    if (fa != 0.0 && fb != 0.0) {
      if ((fa > 0.0) == (fb > 0.0)) return;
      // Next to an end that may be a critical point f is flat, and Newton's method wants more; a
      // seed is nearer than both ends in any case.
      const auto [least, largest] = std::minmax({std::abs(fa), std::abs(fb)});
      const double near =
          kSeedShare * (least < kFlatShare * largest ? least : std::min(largest, 5.0 * least));
      const auto value = [&](double w) {
        at = path(w);
        return at.finite ? f.value(at) : 0.0;
      };
      geometry::illinois_root(value, [&](double, double v) { return std::abs(v) <= near; }, 0.0,
                              1.0, fa, fb);
      // Paths that end, or jump to another part of a later surface, change the sign without a zero.
      if (!at.finite || std::abs(f.value(at)) > near) return;
    }
    seeds.push_back({target, at, cell.radius});
  }

  // Where φ along an edge turns back and passes a level that neither end shows, by the cubic through
  // both values and slopes.
  std::optional<double> turning_point(const Corner& a, const Corner& b) const {
    const FieldPoint& fa = e_.samples[a.sample];
    const FieldPoint& fb = e_.samples[b.sample];
    const double pa = phi(fa), pb = phi(fb);
    if (!std::isfinite(pa) || !std::isfinite(pb)) return std::nullopt;
    const Vec3 along = fb.x - fa.x;
    const double da = fa.inverse_irradiance_gradient().dot(along);
    const double db = fb.inverse_irradiance_gradient().dot(along);
    if (da * db >= 0.0) return std::nullopt;
    const double w = da / (da - db), v = 1.0 - w;
    const double top = pa * v * v * (1.0 + 2.0 * w) + pb * w * w * (3.0 - 2.0 * w) +
                       da * w * v * v - db * w * w * v;
    // Twice the overshoot, since the cubic is a guess.
    const double end = da > 0.0 ? std::max(pa, pb) : std::min(pa, pb);
    bool passes = false;
    crossings(end, end + 2.0 * (top - end), [&](int) { passes = true; });
    return passes ? std::optional(w) : std::nullopt;
  }

  Evaluator& evaluate_;
  const Domain domain_;
  Exploration& e_;
  const std::vector<LevelFunction>& targets_;
  std::unordered_set<std::uint64_t> seen_;
};

// Newton's method on the two tangential components of ∇φ; their derivatives by differences of the
// closed form, since only the place matters and it converges fast enough.
std::optional<FieldPoint> newton_critical(Evaluator& evaluate, const FieldPoint& start,
                                          double reach) {
  FieldPoint f = start;
  const double h = 1e-5 * reach;
  for (int i = 0; i < 12; ++i) {
    const Vec3 g = f.inverse_irradiance_gradient();
    const auto gradient_at = [&](const Vec3& dx) {
      return evaluate.on_surface(f.x + dx, f.hits.get()).inverse_irradiance_gradient();
    };
    const Vec3 g1 = gradient_at(h * f.e1), g2 = gradient_at(h * f.e2);
    geometry::Mat2 K;
    K << (g1 - g).dot(f.e1), (g2 - g).dot(f.e1), (g1 - g).dot(f.e2), (g2 - g).dot(f.e2);
    const Vec2 step = -h * (K.inverse() * Vec2(g.dot(f.e1), g.dot(f.e2)));
    if (!step.allFinite() || step.norm() > 2.0 * reach) return std::nullopt;
    f = evaluate.on_surface(f.x + step.x() * f.e1 + step.y() * f.e2, f.hits.get());
    if (!f.finite || !f.lit() || (f.x - start.x).norm() > 2.0 * reach) return std::nullopt;
    if (step.norm() <= 1e-9 * reach) return f;
  }
  return std::nullopt;
}

// Both components of ∇φ along the cell's sides change sign among its corners, or nearly: a critical
// point may sit right on a corner.
bool may_hold_critical_point(const Exploration& e, const Cell& cell) {
  const Vec3 side1 = e.samples[cell.polygon[1].sample].x - e.samples[cell.polygon[0].sample].x;
  const Vec3 side2 = e.samples[cell.center].n.cross(side1);
  Vec2 lo = Vec2::Constant(geometry::kInfinity), hi = -lo;
  for (const Corner& corner : cell.polygon) {
    const FieldPoint& f = e.samples[corner.sample];
    if (f.cos_alpha <= kDarkCosine) return false;
    const Vec3 g = f.inverse_irradiance_gradient();
    lo = lo.cwiseMin(Vec2(g.dot(side1), g.dot(side2)));
    hi = hi.cwiseMax(Vec2(g.dot(side1), g.dot(side2)));
  }
  const Vec2 slack = kCornerShare * (hi - lo);
  return (lo.array() <= slack.array()).all() && (hi.array() >= -slack.array()).all();
}

}  // namespace

std::vector<CriticalPoint> find_critical_points(Evaluator& evaluate, const Domain& domain,
                                                const Exploration& e) {
  std::vector<CriticalPoint> found;
  for (std::size_t i = 0; i < e.cells.size(); ++i) {
    const Cell& cell = e.cells[i];
    if (!may_hold_critical_point(e, cell) || !e.samples[cell.center].lit()) continue;
    if (evaluate.budget().exhausted()) break;
    const auto f = newton_critical(evaluate, e.samples[cell.center], cell.radius);
    if (!f || !domain.contains(*f)) continue;
    const bool again = std::any_of(found.begin(), found.end(), [&](const CriticalPoint& c) {
      return (c.field.x - f->x).norm() < 1e-6 * cell.radius;
    });
    if (!again) found.push_back({*f, static_cast<int>(i)});
  }
  return found;
}

std::vector<Seed> find_seeds(Evaluator& evaluate, Exploration& e,
                             const std::vector<CriticalPoint>& critical,
                             const std::vector<LevelFunction>& targets) {
  Seeder seeder(evaluate, e, targets);
  for (std::size_t i = 0; i < e.cells.size(); ++i) {
    if (i % kBetweenChecks == 0 && evaluate.budget().exhausted()) break;
    const Cell& cell = e.cells[i];
    for (std::size_t k = 0; k < cell.polygon.size(); ++k) {
      if (cell.polygon[k].boundary == kPathEnds) continue;  // E = 0 along it
      seeder.edge(cell, cell.polygon[k], cell.polygon[(k + 1) % cell.polygon.size()]);
    }
  }
  for (const CriticalPoint& c : critical) {
    const Cell& cell = e.cells[c.cell];
    for (const Corner& corner : cell.polygon) {
      seeder.spoke(cell, c.field, FieldPoint(e.samples[corner.sample]));
    }
  }
  return std::move(seeder.seeds);
}

}  // namespace caustic::solver
