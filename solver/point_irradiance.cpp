#include "solver/point_irradiance.h"

#include <cmath>

#include "solver/itineraries.h"
#include "solver/plan.h"

namespace caustic::solver {

namespace {

// |a| below this share of its natural scale: a point this near to the caustic, about the square of
// the share in lengths of the image, cannot be told from one on it after rounding.
constexpr double kCausticShare = 1e-7;

}  // namespace

LightMeter::LightMeter(const OpticalSystem& system, const std::vector<Family>& families,
                       bool direct)
    : system_(system), families_(families.empty() ? families_up_to(system, 1) : families) {
  if (direct) direct_.emplace(system, Hops{});
  for (const Family& family : families_) finders_.emplace_back(system, family, system.light());
}

const ForwardMap& LightMeter::map_of(int family, const std::vector<Point>& hits) {
  Hops hops;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    Vec3 N;
    system_.surfaces()[families_[family][i]].shape->value_gradient(hits[i], N);
    const Vec3 in =
        i == 0 ? finders_[family].tracer().incident(hits[0]) : Vec3(hits[i] - hits[i - 1]);
    hops.push_back({families_[family][i], N.dot(in) < 0.0 ? 1 : -1});
  }
  auto& map = maps_[{family, hops}];
  if (!map) map = std::make_unique<ForwardMap>(system_, hops);
  return *map;
}

PointIrradiance LightMeter::at(const Vec2& q) {
  PointIrradiance sum;
  const Point p = system_.receiver().point(q);
  for (int id = 0; id < static_cast<int>(families_.size()); ++id) {
    auto answer = finders_[id].to(p);
    sum.on_caustic |= answer.undecided > 0;
    for (FamilyPath& way : answer.paths) {
      const FieldPoint f = map_of(id, way.path.x).evaluate(way.path.x.front());
      if (!f.finite || !(f.flux > 0.0)) continue;  // parallel to the receiver, or grazing: E = 0
      if (std::abs(f.a) <= kCausticShare * f.scale_of_a() || f.looks_degenerate()) {
        sum.on_caustic = true;
        continue;
      }
      add(id, f, std::move(way.path.x), sum);
    }
  }
  if (direct_) add_direct(p, sum);
  if (sum.on_caustic) {
    sum.E = 0.0;
    sum.gradient.setZero();
  }
  return sum;
}

// One sheet more.
void LightMeter::add(int family, const FieldPoint& f, std::vector<Point> hits,
                     PointIrradiance& sum) const {
  const auto& receiver = system_.receiver();
  const Vec2 slope = f.irradiance_gradient();
  const Vec3 gradient = slope.x() * receiver.u + slope.y() * receiver.v;
  sum.E += f.irradiance();
  sum.gradient += gradient;
  sum.sheets.push_back(
      {family, f.a > 0.0 ? 1 : -1, f.irradiance(), gradient, f.x, std::move(hits)});
}

// Unless something stands in the way.
void LightMeter::add_direct(const Point& p, PointIrradiance& sum) const {
  const FieldPoint f = direct_->evaluate(p);
  if (!f.finite || !(f.flux > 0.0)) return;
  Point from;
  if (const auto* point = std::get_if<PointLight>(&system_.light())) {
    from = point->position;
  } else {
    double reach = 0.0;
    for (const auto& s : system_.surfaces()) {
      reach = std::max(reach, (s.region.center() - p).norm() + s.region.diagonal());
    }
    from = p - reach * direct_->incident(p);
  }
  if (!segment_hidden(system_, from, -1, p, -1)) add(kDirectFamily, f, {}, sum);
}

}  // namespace caustic::solver
