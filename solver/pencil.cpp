#include "solver/pencil.h"

#include <cmath>

namespace caustic::solver {

namespace {

// A ray leaves the surface it starts on: crossings this close, as a share of its reach, are its
// start.
constexpr double kStartShare = 1e-10;

// Largest bound at x: ≤ 0 where the surface exists.
double beyond(const std::vector<geometry::Bound>& bounds, const Point& x) {
  double worst = -geometry::kInfinity;
  for (const auto& bound : bounds) worst = std::max(worst, bound.value(x));
  return worst;
}

}  // namespace

PathSurface path_surface(const SystemSurface& surface) {
  const Optics& optics = surface.optics;
  return {surface.shape.get(),   &surface.bounds,      surface.region,
          optics.kind != Optics::Kind::refract, optics.index_outside, optics.index_inside};
}

PencilTracer::PencilTracer(std::vector<PathSurface> surfaces, Light light, double reach)
    : surfaces_(std::move(surfaces)), light_(std::move(light)), reach_(reach) {}

Vec3 PencilTracer::incident(const Point& x) const {
  if (const auto* point = std::get_if<PointLight>(&light_)) return x - point->position;
  return std::get<CollimatedLight>(light_).direction;
}

bool PencilTracer::next_hit(const PathSurface& surface, const geometry::Ray& ray, double& t) const {
  thread_local geometry::RayParameters roots;
  roots.clear();
  surface.shape->crossings(ray, kStartShare * reach_, reach_, roots);
  double nearest = geometry::kInfinity;
  for (const double root : roots) {
    const double outside = beyond(*surface.bounds, ray.at(root));
    if (outside >= nearest) continue;
    nearest = outside;
    t = root;
    if (outside <= 0.0) break;
  }
  return !roots.empty();
}

// mathematics.md §2: transfer, normal, reflection and refraction, each with its derivative.
template <bool differential>
bool PencilTracer::follow(const Point& x, Pencil& pencil) const {
  Vec3 w = incident(x);
  const double distance = w.norm();
  if (!(distance > 0.0)) return false;
  w /= distance;
  Point o = x;
  Mat3 dx = Mat3::Identity(), dw = Mat3::Zero();
  if (light_.index() == 0) dw = (Mat3::Identity() - w * w.transpose()) / distance;

  pencil.missed = -1;
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    const PathSurface& surface = surfaces_[i];
    double tau = 0.0;
    if (i > 0) {
      if (!next_hit(surface, {o, w}, tau)) {
        pencil.o = o;
        pencil.w = w;
        pencil.dx = dx;
        pencil.dw = dw;
        pencil.missed = static_cast<int>(i);
        return false;
      }
      o += tau * w;
    }
    pencil.hits[i] = o;
    geometry::SurfaceDerivatives d;
    if constexpr (differential) {
      d = surface.shape->derivatives(o);
    } else {
      surface.shape->value_gradient(o, d.gradient);
    }
    const double length = d.gradient.norm();
    if (!(length > 0.0)) return false;
    const Vec3 n = d.gradient / length;
    const double c = w.dot(n);
    Mat3 dn;
    if constexpr (differential) {
      if (i > 0) {
        dx += tau * dw;
        const Eigen::RowVector3d dtau = -(n.transpose() * dx) / c;
        dx += w * dtau;
      }
      const Mat3 Hdx = d.hessian * dx / length;
      dn = Hdx - n * (n.transpose() * Hdx);
    }
    if (surface.reflects) {
      if constexpr (differential) {
        const Eigen::RowVector3d dc = n.transpose() * dw + w.transpose() * dn;
        dw -= 2.0 * (n * dc + c * dn);
      }
      w -= 2.0 * c * n;
    } else {
      const double eta = c < 0.0 ? surface.index_outside / surface.index_inside
                                 : surface.index_inside / surface.index_outside;
      const double xi = 1.0 - eta * eta * (1.0 - c * c);
      if (!(xi > 0.0)) return false;
      const double out = std::copysign(std::sqrt(xi), c), mu = eta * c - out;
      if constexpr (differential) {
        const Eigen::RowVector3d dc = n.transpose() * dw + w.transpose() * dn;
        const Eigen::RowVector3d dmu = (eta - eta * eta * c / out) * dc;
        dw = (eta * dw - mu * dn - n * dmu).eval();
      }
      w = eta * w - mu * n;
    }
  }
  pencil.o = o;
  pencil.w = w;
  pencil.dx = dx;
  pencil.dw = dw;
  return w.allFinite() && o.allFinite();
}

template bool PencilTracer::follow<true>(const Point&, Pencil&) const;
template bool PencilTracer::follow<false>(const Point&, Pencil&) const;

SpecularChain PencilTracer::chain(const std::vector<Point>& hits) const {
  // Ratios of indices, one surface after the other: the medium between two surfaces has one index,
  // and where a scene says two, the law of each surface still holds.
  SpecularChain chain;
  double index = 1.0, first = 1.0;
  bool known = false;
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    const PathSurface& surface = surfaces_[i];
    SpecularHop hop{surface.shape, surface.reflects, index, index};
    if (!surface.reflects) {
      Vec3 N;
      surface.shape->value_gradient(hits[i], N);
      const Vec3 in = i == 0 ? incident(hits[0]) : Vec3(hits[i] - hits[i - 1]);
      const bool from_outside = N.dot(in) < 0.0;
      const double before = from_outside ? surface.index_outside : surface.index_inside;
      const double after = from_outside ? surface.index_inside : surface.index_outside;
      if (!known) first = before;
      known = true;
      hop.index_after = index *= after / before;
    }
    chain.push_back(hop);
  }
  for (SpecularHop& hop : chain) {
    hop.index_before *= first;
    hop.index_after *= first;
  }
  return chain;
}

}  // namespace caustic::solver
