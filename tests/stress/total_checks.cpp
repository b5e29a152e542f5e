// Totals: rings that close, and what a meter reads on arcs, beside jumps and at random places. The
// meter's paths are the program's, found by another search; what each of them carries is the
// oracle's.
#include <algorithm>
#include <cmath>
#include <map>

#include "solver/point_irradiance.h"
#include "tests/stress/checks.h"
#include "tests/support/distance_to.h"

namespace caustic::stress {
namespace {

using solver::Curve;
using solver::CurveKind;

std::vector<Family> families_of(const Trial& trial) {
  std::vector<Family> out;
  for (const auto& family : trial.result.families) out.push_back(family.surfaces);
  return out;
}

class Total {
 public:
  explicit Total(const Subject& s)
      : s_(s),
        families_(families_of(s.trial)),
        meter_(s.trial.call.system, families_, s.trial.call.request.direct) {}

  const std::vector<Family>& families() const { return families_; }

  struct Sum {
    double E = 0.0;
    bool exact = true;      ///< false on a caustic, or where a path could not be followed
    double rounding = 0.0;  ///< relative
    std::size_t sheets = 0;
    Vec2 gradient = Vec2::Zero();
  };
  /// In long double, or, where that is not enough, in 50 digits.
  Sum at(const Vec2& q, bool all_digits = false) {
    const auto reading = meter_.at(q);
    Sum sum{.exact = !reading.on_caustic, .sheets = reading.sheets.size()};
    const auto& r = s_.trial.receiver();
    sum.gradient = {r.u.dot(reading.gradient), r.v.dot(reading.gradient)};
    for (const auto& sheet : reading.sheets) {
      const Family family = sheet.family_id < 0 ? Family() : families_[sheet.family_id];
      const auto near = s_.oracle.distances(family, sheet.x, q);
      const auto own = all_digits ? s_.oracle.exact(family, sheet.x, near)
                                  : s_.oracle.quick(family, sheet.x, near);
      if (!own || (!family.empty() && near.empty())) {
        sum.exact = false;
        continue;
      }
      sum.E += own->E;
      // The place is met by the program to rounding only.
      sum.rounding += (own->q - q).norm() * sheet.gradient.norm();
    }
    if (sum.E > 0.0) sum.rounding /= sum.E;
    return sum;
  }
  solver::PointIrradiance sheets(const Vec2& q) { return meter_.at(q); }

 private:
  const Subject& s_;
  std::vector<Family> families_;
  solver::LightMeter meter_;
};

bool bounds_level(const Curve& c) {
  return c.kind == CurveKind::isolux || c.kind == CurveKind::jump ||
         c.kind == CurveKind::receiver_edge;
}

double distance_to_level(const solver::ContourResult& result, double level, const Vec2& q) {
  double least = geometry::kInfinity;
  for (const Curve& c : result.curves)
    if (bounds_level(c) && c.level == level) least = std::min(least, test::distance_to(c, q));
  return least;
}

/// How often the rings of a level wind about q.
int winding(const solver::ContourResult& result, double level, const Vec2& q) {
  int turns = 0;
  for (const Curve& c : result.curves) {
    if (!bounds_level(c) || c.level != level) continue;
    const std::size_t n = c.vertices.size();
    for (std::size_t i = 0; i + (c.closed ? 0 : 1) < n; ++i) {
      const Vec2 a = c.vertices[i].uv - q, b = c.vertices[(i + 1) % n].uv - q;
      if ((a.y() > 0.0) == (b.y() > 0.0)) continue;
      const bool upward = b.y() > a.y();
      if ((geometry::cross(a, b) > 0.0) == upward) turns += upward ? 1 : -1;
    }
  }
  return turns;
}

Finding wrong_arc(const Subject& s, Total& total, const Curve& c, std::size_t i) {
  const auto& v = c.vertices[i];
  const auto is_wrong = [&](const Total::Sum& sum) {
    return std::abs(sum.E / c.level - 1.0) >
           s.trial.call.request.irradiance_tolerance + 1e-8 + 4.0 * sum.rounding;
  };
  auto sum = total.at(v.uv);
  if (sum.exact && is_wrong(sum)) sum = total.at(v.uv, true);
  if (!sum.exact) return std::nullopt;
  if (is_wrong(sum)) return text("total %.12g of %zu sheets there", sum.E, sum.sheets);
  const Vec2 along = c.vertices[i + 1].uv - c.vertices[i - 1].uv;
  if (sum.gradient.dot(Vec2(-along.y(), along.x())) < -1e-6 * sum.gradient.norm() * along.norm())
    return "the brighter side is on the right";
  return std::nullopt;
}

/// What is read at this distance from both sides of a jump, against what it says.
Finding wrong_beside(Total& total, const Curve& c, std::size_t i, double step) {
  const auto& v = c.vertices[i];
  const Vec2 along = (c.vertices[i + 1].uv - c.vertices[i - 1].uv).normalized();
  const Vec2 left(-along.y(), along.x());
  const auto dark = total.at(v.uv - step * left), bright = total.at(v.uv + step * left);
  const auto slack = [&](const Total::Sum& sum) {
    return 1e-2 * c.level + 20.0 * step * sum.gradient.norm();
  };
  if (dark.exact && std::abs(dark.E - v.dark) > slack(dark))
    return text("dark side %.9g, beside it %.9g", v.dark, dark.E);
  if (bright.exact && v.bright >= 0.0 && std::abs(bright.E - v.bright) > slack(bright))
    return text("bright side %.9g, beside it %.9g", v.bright, bright.E);
  return std::nullopt;
}

/// A jump is level on neither side: beside it the total is below and above.
Finding wrong_jump(const Subject& s, Total& total, const Curve& c, std::size_t i) {
  const auto& v = c.vertices[i];
  const double unit = s.trial.receiver().width() + s.oracle.size();
  const double from_end =
      std::min((v.uv - c.vertices.front().uv).norm(), (v.uv - c.vertices.back().uv).norm());
  if (!c.closed && from_end < 1e-4 * unit) return std::nullopt;
  if (v.dark >= c.level * (1.0 + 1e-8)) return text("dark side %.9g", v.dark);
  if (v.bright >= 0.0 && v.bright < c.level * (1.0 - 1e-8))
    return text("bright side %.9g", v.bright);
  // What hides light within rounding of its arrival does not count for the meter, so not too close;
  // and the light of a sliver is beside its edge only, so not too far.
  const auto wrong = wrong_beside(total, c, i, 1e-6 * unit);
  if (wrong && !wrong_beside(total, c, i, 1e-9 * unit)) return std::nullopt;
  return wrong;
}

}  // namespace

Finding check_rings(const Subject& s) {
  if (!s.trial.total()) return std::nullopt;
  std::map<int, std::map<int, const Curve*>> rings;
  for (const Curve& c : s.trial.result.curves)
    if (bounds_level(c) && !rings[c.ring_id].emplace(c.ring_order, &c).second)
      return text("ring %d has two arcs %d", c.ring_id, c.ring_order);
  for (const auto& [id, arcs] : rings) {
    if (arcs.size() == 1 && arcs.begin()->second->closed) continue;
    for (const auto& [order, arc] : arcs) {
      const auto next = arcs.find((order + 1) % static_cast<int>(arcs.size()));
      if (next == arcs.end() || arc->closed) return text("ring %d lacks an arc", id);
      const double gap = (next->second->vertices.front().uv - arc->vertices.back().uv).norm();
      if (gap > 1e-6 * s.trial.receiver().width())
        return text("ring %d opens by %.3g m after arc %d", id, gap, order);
    }
  }
  return std::nullopt;
}

Finding check_meter(const Subject& s) {
  if (!s.trial.total() || s.trial.result.families.empty()) return std::nullopt;
  Total total(s);
  const auto& curves = s.trial.result.curves;
  for (const std::size_t k : spread_over(curves.size(), 10 * s.effort)) {
    const Curve& c = curves[k];
    const std::size_t n = c.vertices.size();
    if (late(s) || n < 3 || (c.kind != CurveKind::isolux && c.kind != CurveKind::jump)) continue;
    for (const std::size_t i : {n / 3, 2 * n / 3}) {
      if (i < 1 || i + 1 >= n) continue;
      const auto wrong =
          c.kind == CurveKind::isolux ? wrong_arc(s, total, c, i) : wrong_jump(s, total, c, i);
      if (wrong) return name_of(s.trial, k) + text(", vertex %zu of %zu: ", i, n) + *wrong;
    }
  }
  return std::nullopt;
}

Finding check_inside(const Subject& s) {
  if (!s.trial.total() || s.trial.result.families.empty()) return std::nullopt;
  Total total(s);
  test::Random random(s.seed);
  const Vec2 half = s.trial.receiver().half;
  for (int k = 0; k < 24 * s.effort && !late(s); ++k) {
    Vec2 q(random.uniform(-half.x(), half.x()), random.uniform(-half.y(), half.y()));
    // Half of the places close to a curve: what is missing is often small, and next to others.
    const auto& curves = s.trial.result.curves;
    if (k % 2 == 1 && !curves.empty()) {
      const Curve& c = curves[random.index(static_cast<int>(curves.size()))];
      const auto& v = c.vertices[random.index(static_cast<int>(c.vertices.size()))];
      const double angle = random.uniform(0.0, 2.0 * geometry::kPi);
      q = v.uv + random.log_uniform(4.0 * s.trial.chord(), 2.0 * half.minCoeff()) *
                     Vec2(std::cos(angle), std::sin(angle));
      if ((q.cwiseAbs() - half).maxCoeff() > 0.0) continue;
    }
    const auto sum = total.at(q);
    if (!sum.exact) continue;
    for (const double level : s.trial.result.levels) {
      const bool inside = winding(s.trial.result, level, q) != 0;
      const bool bright = sum.E >= level;
      if (inside == bright || std::abs(sum.E / level - 1.0) < 1e-6) continue;
      const double distance = distance_to_level(s.trial.result, level, q);
      if (distance < 2.0 * s.trial.chord()) continue;
      return text("at (%.9g, %.9g) m the total is %.9g, %s of level %.9g, %.3g m from its curves",
                  q.x(), q.y(), sum.E, inside ? "inside" : "outside", level, distance);
    }
  }
  return std::nullopt;
}

}  // namespace caustic::stress
