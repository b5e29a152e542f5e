// Random rays of the light, followed by the oracle through the whole scene. Of each neighbourhood
// in which one sheet passes a level, the place where it does must be on a curve; of the total, each
// ray's sheet must be known to the meter.
#include <algorithm>
#include <cmath>

#include "solver/point_irradiance.h"
#include "tests/stress/checks.h"
#include "tests/support/distance_to.h"

namespace caustic::stress {
namespace {

using solver::Curve;
using solver::CurveKind;

class Gun {
 public:
  Gun(const Subject& s) : s_(s), random_(s.seed + 1) {
    for (const auto& family : s.trial.result.families)
      hops_ = std::max(hops_, family.surfaces.size());
    const Trial& trial = s.trial;
    for (const Curve& c : trial.result.curves)
      if (c.family_id >= 0 && !c.vertices.empty()) known_.push_back(&c);
  }

  test::Random& random() { return random_; }
  std::vector<Arrived> at(const Point& target) const {
    return s_.oracle.shoot(target, hops_, false);
  }

  /// Somewhere on a surface, or beside a place that is known to be lit.
  Point target() {
    const auto& surfaces = s_.oracle.scene().surfaces;
    const OracleSurface& surface = surfaces[random_.index(static_cast<int>(surfaces.size()))];
    if (!known_.empty() && random_.index(2) == 0) {
      const Curve& c = *known_[random_.index(static_cast<int>(known_.size()))];
      const auto& v = c.vertices[random_.index(static_cast<int>(c.vertices.size()))];
      return v.x + random_.log_uniform(1e-3, 0.5) * s_.oracle.size() * random_.direction();
    }
    const auto [center, radius] = surface.ball();
    return center + std::min(radius, s_.oracle.size()) * random_.in_cube(0.8);
  }

  /// What arrives by that family and orientation; nothing if it is not exactly one.
  std::optional<Arrived> like(const Arrived& a, const Point& target) const {
    std::optional<Arrived> found;
    for (Arrived& b : at(target)) {
      if (b.family != a.family || b.reading.parity != a.reading.parity) continue;
      found = std::move(b);
    }
    return found;
  }

 private:
  const Subject& s_;
  test::Random random_;
  std::size_t hops_ = 1;
  std::vector<const Curve*> known_;
};

int traced_family(const Trial& trial, const Family& family) {
  for (const auto& f : trial.result.families)
    if (f.surfaces == family) return f.id;
  return -1;
}

/// The place between two rays where E is the level, if the sheet goes on between them.
std::optional<Vec2> between(const Gun& gun, Arrived a, Point at_a, Arrived b, Point at_b,
                            double level) {
  const bool above = a.reading.E > level;
  for (int i = 0; i < 30; ++i) {
    const Point middle = 0.5 * (at_a + at_b);
    const auto m = gun.like(a, middle);
    if (!m) return std::nullopt;
    if ((m->reading.E > level) == above) {
      a = *m, at_a = middle;
    } else {
      b = *m, at_b = middle;
    }
    if (std::abs(a.reading.E - b.reading.E) < 1e-7 * level) break;
  }
  if (std::abs(a.reading.E / level - 1.0) > 1e-4) return std::nullopt;  // it jumped
  return 0.5 * (a.reading.q + b.reading.q);
}

double random_step(const Subject& s, test::Random& random) {
  return random.log_uniform(1e-3, 0.3) * s.oracle.size();
}

/// True if all rays beside it arrive alike: on an edge two ways of rounding may differ.
bool robust(const Gun& gun, const Arrived& a, const Point& target, double by) {
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)})
    if (!gun.like(a, target + by * axis) || !gun.like(a, target - by * axis)) return false;
  return true;
}

Finding missing_curve(const Subject& s, Gun& gun, const Arrived& a, const Point& target) {
  const int family = traced_family(s.trial, a.family);
  if (family < 0) return std::nullopt;  // too little flux, or not asked for
  const Point beside = target + random_step(s, gun.random()) * gun.random().direction();
  const auto b = gun.like(a, beside);
  if (!b) return std::nullopt;
  for (const double level : s.trial.result.levels) {
    if ((a.reading.E > level) == (b->reading.E > level)) continue;
    const auto q = between(gun, a, target, *b, beside, level);
    if (!q) continue;
    double least = geometry::kInfinity;
    for (const Curve& c : s.trial.result.curves)
      if (c.kind == CurveKind::isolux && c.level == level && c.family_id == family &&
          c.parity == a.reading.parity)
        least = std::min(least, test::distance_to(c, *q));
    if (least > 3.0 * s.trial.chord() + 1e-7 * s.trial.receiver().width())
      return text(
          "family %d, parity %d passes level %.9g at (%.9g, %.9g) m, %.3g m from its curves",
          family, a.reading.parity, level, q->x(), q->y(), least);
  }
  return std::nullopt;
}

}  // namespace

Finding check_rays(const Subject& s) {
  Gun gun(s);
  std::vector<Family> families;
  for (const auto& f : s.trial.result.families) families.push_back(f.surfaces);
  if (families.empty()) return std::nullopt;
  solver::LightMeter meter(s.trial.call.system, families, false);
  for (int k = 0; k < 60 * s.effort && !late(s); ++k) {
    const Point target = gun.target();
    for (const Arrived& a : gun.at(target)) {
      if (!s.trial.total()) {
        if (const auto missing = missing_curve(s, gun, a, target)) return missing;
        continue;
      }
      const int family = traced_family(s.trial, a.family);
      if (family < 0) continue;
      const auto reading = meter.at(a.reading.q);
      double least = geometry::kInfinity;
      for (const auto& sheet : reading.sheets)
        if (sheet.family_id == family) least = std::min(least, (sheet.x - a.x).norm());
      const double hit_error = 1e-7 * s.oracle.size();
      if (reading.on_caustic || least < hit_error) continue;
      if (!robust(gun, a, target, 1e-6 * s.oracle.size())) continue;
      return text(
          "a ray by family %d reaches (%.9g, %.9g) m from x (%.9g, %.9g, %.9g) m; the meter's "
          "nearest is %.3g m away",
          family, a.reading.q.x(), a.reading.q.y(), a.x.x(), a.x.y(), a.x.z(), least);
    }
  }
  return std::nullopt;
}

}  // namespace caustic::stress
