#include "solver/mean_share.h"

#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cmath>

namespace caustic::solver {

namespace {

// Seven points of Gauss in fifteen of Kronrod, halved where they differ by more than this share.
constexpr double kShareTolerance = 1e-9;
constexpr unsigned kMaxShareHalvings = 14;
// Surfaces are followed this far beyond the box of what exists of them, in its diagonals.
constexpr double kBeyond = 0.05;

}  // namespace

MeanShare::MeanShare(const ForwardMap& map, const Vec3& axis)
    : map_(map), axis_(axis), reach_(2.0 * map.mirror().region.diagonal()) {
  const Point center = map.mirror().region.center();
  if (const auto* point = std::get_if<PointLight>(&map.system().light()))
    reach_ += (center - point->position).norm();
  else
    reach_ += (center - axis).norm();
}

// Where the ray first meets the lit side, if it can on a part that exists, else beyond: any share
// will do there, as long as it depends on the ray alone.
double MeanShare::on_ray(const geometry::Ray& ray) const {
  geometry::RayParameters crossings;
  const geometry::Box& box = map_.mirror().region;
  const auto [begin, end] = box.span_of(ray, kBeyond * box.diagonal());
  if (!(begin < end)) return 0.0;
  map_.shape().crossings(ray, begin, end, crossings);
  std::optional<Point> hit;
  for (const double t : crossings) {
    const Point x = ray.at(t);
    Vec3 N;
    map_.shape().value_gradient(x, N);
    if (!(map_.side() * N.dot(ray.direction) < 0.0)) continue;
    const bool exists = geometry::exists_at(map_.mirror().bounds, x);
    if (!hit || exists) hit = x;
    if (exists) break;
  }
  if (!hit) return 0.0;
  const FieldPoint f = map_.evaluate(*hit);
  return f.finite ? f.share : 0.0;
}

Estimate MeanShare::at(const Point& x) const {
  const auto mean = [](const auto& ray_at) {
    Estimate out;
    using Rule = boost::math::quadrature::gauss_kronrod<double, 15>;
    out.value = Rule::integrate(ray_at, 0.0, 1.0, kMaxShareHalvings, kShareTolerance, &out.error);
    return out;
  };
  if (const auto* point = std::get_if<PointLight>(&map_.system().light())) {
    const Vec3 d = (x - point->position).normalized(), across = d - axis_ * axis_.dot(d);
    const Vec3 aside = across.norm() > 0.0 ? Vec3(across.normalized()) : Vec3::Zero();
    const double drop = 1.0 - axis_.dot(d);  // 1 − cos θ, by which rays are spread evenly
    return mean([&](double nu) {
      const double below = nu * nu * drop;
      const Vec3 direction = (1.0 - below) * axis_ + std::sqrt(below * (2.0 - below)) * aside;
      return 2.0 * nu * on_ray({point->position, reach_ * direction});
    });
  }
  const Vec3& beam = std::get<CollimatedLight>(map_.system().light()).direction;
  const Vec3 r = x - axis_, across = r - beam * beam.dot(r);
  return mean([&](double nu) {
    return 2.0 * nu * on_ray({axis_ + nu * across - reach_ * beam, 2.0 * reach_ * beam});
  });
}

}  // namespace caustic::solver
