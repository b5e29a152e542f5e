#include "solver/hop.h"

#include <cmath>

namespace caustic::solver {

using geometry::Jet;
using geometry::Ray;
using geometry::SurfaceDerivatives;

namespace {

// Where a ray is looked for beyond the part of a surface that exists, in its diameters, so that
// aperture edges are seen from both sides.
constexpr double kReachBeyond = 2.0;
// A hit belongs to a guess within this share of it.
constexpr double kGuessShare = 0.1;

// Newton's method along the ray.
std::optional<double> hit_near(const SystemSurface& surface, int side, const Ray& ray, double guess) {
  Vec3 N;
  double t = guess;
  for (int i = 0; i < 8; ++i) {
    const double g = surface.shape->value_gradient(ray.at(t), N);
    const double slope = N.dot(ray.direction);
    if (!(side * slope < 0.0)) return std::nullopt;
    const double step = -g / slope;
    t += step;
    if (!(t > 0.0 && std::abs(t - guess) <= kGuessShare * guess)) return std::nullopt;
    // The next step would be of the order of this one squared.
    if (std::abs(step) <= 1e-9 * t) return t;
  }
  return std::nullopt;
}

}  // namespace

double least_return(const Ray& ray, double scale) {
  constexpr double kRoundings = 1e3;
  return kRoundings * geometry::kEpsilon * (ray.origin.cwiseAbs().maxCoeff() + scale) /
         ray.direction.norm();
}

std::optional<double> next_hit(const SystemSurface& surface, int side, const Ray& ray, double least,
                               const double* guess) {
  if (guess) {
    if (const auto t = hit_near(surface, side, ray, *guess)) return t;
  }
  thread_local geometry::RayParameters roots;
  roots.clear();
  const double reach = (surface.region.center() - ray.origin).norm() +
                       kReachBeyond * surface.region.diagonal();
  surface.shape->crossings(ray, 0.0, reach / ray.direction.norm(), roots);
  std::optional<double> best;
  double best_badness = geometry::kInfinity;
  Vec3 N;
  for (const double t : roots) {
    const Point y = ray.at(t);
    surface.shape->value_gradient(y, N);
    if (!(t > least && side * N.dot(ray.direction) < 0.0)) continue;
    double badness = 0.0;
    if (guess) {
      badness = std::abs(t - *guess);
    } else {
      for (const auto& bound : surface.bounds) badness = std::max(badness, bound.value(y));
    }
    if (badness >= best_badness) continue;
    best_badness = badness;
    best = t;
    if (badness == 0.0) break;
  }
  return best;
}

std::optional<Vec3> bend(const Optics& optics, int side, const Vec3& d, const Vec3& N) {
  const double c = d.dot(N), nn = N.squaredNorm();
  if (optics.kind == Optics::Kind::mirror) return d - (2.0 * c / nn) * N;
  const double eta = optics.eta(side);
  const double radicand = (1.0 - eta * eta) * nn * d.squaredNorm() + eta * eta * c * c;
  if (!(radicand > 0.0)) return std::nullopt;
  return eta * d - ((eta * c + side * std::sqrt(radicand)) / nn) * N;
}

VecJet normal_jet(const geometry::Surface& shape, const SurfaceDerivatives& at, const VecJet& x,
                  bool third) {
  const auto& H = at.hessian;
  VecJet N{at.gradient, H * x.s, H * x.t, H * x.ss, H * x.st, H * x.tt};
  if (third) {
    const auto T = shape.third_derivatives(x.v, x.s, x.t);
    N.ss += T.uu;
    N.st += T.uv;
    N.tt += T.vv;
  }
  return N;
}

void transfer(RayJet& ray, double tau, const SurfaceDerivatives& at) {
  const VecJet &x = ray.x, &d = ray.d;
  const Vec3& G = at.gradient;
  const double inverse = -1.0 / G.dot(d.v);
  VecJet y;
  y.v = x.v + tau * d.v;
  // g = 0 along the surface, differentiated once …
  y.s = x.s + tau * d.s;
  y.t = x.t + tau * d.t;
  const double tau_s = inverse * G.dot(y.s), tau_t = inverse * G.dot(y.t);
  y.s += tau_s * d.v;
  y.t += tau_t * d.v;
  // … and twice.
  const Vec3 H_s = at.hessian * y.s, H_t = at.hessian * y.t;
  y.ss = x.ss + tau * d.ss + 2.0 * tau_s * d.s;
  y.st = x.st + tau * d.st + tau_s * d.t + tau_t * d.s;
  y.tt = x.tt + tau * d.tt + 2.0 * tau_t * d.t;
  y.ss += inverse * (G.dot(y.ss) + y.s.dot(H_s)) * d.v;
  y.st += inverse * (G.dot(y.st) + y.s.dot(H_t)) * d.v;
  y.tt += inverse * (G.dot(y.tt) + y.t.dot(H_t)) * d.v;
  ray.x = y;
}

bool bend(const Optics& optics, int side, const VecJet& N, RayJet& ray, Bounce& bounce) {
  VecJet& d = ray.d;
  const Jet c = dot(d, N), nn = dot(N, N), dd = dot(d, d);
  const Jet size = nn * dd;
  bounce.cosine = static_cast<double>(-side) * (c / sqrt(size));
  if (optics.kind == Optics::Kind::mirror) {
    bounce.headroom = {1.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    d = d - (2.0 * (c / nn)) * N;
    return true;
  }
  const double eta = optics.eta(side);
  const Jet radicand = (1.0 - eta * eta) * size + (eta * eta) * (c * c);
  if (!(radicand.v > 0.0)) return false;
  bounce.headroom = radicand / size;
  const Jet turn = (eta * c + static_cast<double>(side) * sqrt(radicand)) / nn;
  d = eta * d - turn * N;
  return true;
}

}  // namespace caustic::solver
