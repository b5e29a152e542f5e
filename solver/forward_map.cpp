#include "solver/forward_map.h"

#include <cmath>

#include "geometry/jet.h"

namespace caustic::solver {

using geometry::Jet;
using geometry::Mat3;

ForwardMap::ForwardMap(const OpticalSystem& system, int surface, int side)
    : mirror_(&system.surfaces()[surface]),
      receiver_(&system.receiver()),
      surface_(surface),
      side_(side),
      quadratic_(mirror_->shape->at_most_quadratic()),
      scale_(system.diameter()) {
  if (const auto* point = std::get_if<PointLight>(&system.light())) {
    point_source_ = true;
    source_ = point->position;
    strength_ = mirror_->optics.reflectance * point->intensity;
  } else {
    const auto& beam = std::get<CollimatedLight>(system.light());
    point_source_ = false;
    source_ = beam.direction;
    strength_ = mirror_->optics.reflectance * beam.irradiance;
  }
  to_receiver_ << receiver_->u.transpose(), receiver_->v.transpose(), receiver_->m.transpose();
}

Vec3 ForwardMap::incident(const Point& x) const { return point_source_ ? Vec3(x - source_) : source_; }

Vec3 ForwardMap::reflected(const Point& x) const {
  Vec3 N;
  shape().value_gradient(x, N);
  const Vec3 d = incident(x);
  return d - (2.0 * d.dot(N) / N.squaredNorm()) * N;
}

Vec2 ForwardMap::arrival(const Point& x) const {
  const Vec3 D = to_receiver_ * reflected(x), y = to_receiver_ * (x - receiver_->origin);
  const double lambda = -y.z() / D.z();
  return {y.x() + lambda * D.x(), y.y() + lambda * D.y()};
}

double ForwardMap::rounding(const Point& x) const {
  return geometry::kEpsilon * (x.cwiseAbs().maxCoeff() + scale_);
}

Point ForwardMap::project(const Point& start) const {
  Point x = start;
  Vec3 gradient;
  for (int i = 0; i < 6; ++i) {
    const double g = shape().value_gradient(x, gradient);
    const Vec3 step = gradient * (g / gradient.squaredNorm());
    if (!step.allFinite()) return start;
    x -= step;
    // The next step would be of the order of this one squared over a radius of curvature.
    if (step.squaredNorm() <= 1e-20 * scale_ * scale_) break;
  }
  return x;
}

namespace {

// A ray exactly parallel to the receiver arrives this many lengths away instead of nowhere, so that
// the pole of (S4) stays a number; its square still fits a double after two derivatives.
constexpr double kParallel = 1e-30;
// a below this share of |∂q/∂s|² + |∂q/∂t|² is zero to rounding; so are |∂q| below it.
constexpr double kDegenerateShare = 1e-9;
// Least natural scale of a, in squared stretches of the map.
constexpr double kLeastScale = 1e-6;

}  // namespace

FieldPoint ForwardMap::evaluate(const Point& x) const {
  FieldPoint f;
  f.x = x;
  const auto g = shape().derivatives(x);
  const Vec3& G = g.gradient;
  const double NN0 = G.squaredNorm();
  const double inverse_norm = 1.0 / std::sqrt(NN0);
  const Direction g_hat = G * inverse_norm;
  f.n = side_ * g_hat;
  const geometry::Frame frame(f.n);
  f.e1 = frame.e1;
  f.e2 = frame.e2;

  // Receiver axes from here on. The surface and its gradient as jets (S1), (S2); for quadrics the
  // second derivatives of N are multiples of Hĝ/|∇g|.
  const Mat3& R = to_receiver_;
  const Vec3 N = R * G, N_s = R * (g.hessian * f.e1), N_t = R * (g.hessian * f.e2);
  const Vec3 e1 = R * f.e1, e2 = R * f.e2, bend = N * (-1.0 / NN0);  // x_ij = h_ij · bend
  const Vec3 Hg = R * (g.hessian * G);
  const double h11 = e1.dot(N_s), h12 = e1.dot(N_t), h22 = e2.dot(N_t);
  Vec3 N_ss = (-h11 / NN0) * Hg, N_st = (-h12 / NN0) * Hg, N_tt = (-h22 / NN0) * Hg;
  if (!quadratic_) {
    N_ss += R * shape().third_derivative(x, f.e1, f.e1);
    N_st += R * shape().third_derivative(x, f.e1, f.e2);
    N_tt += R * shape().third_derivative(x, f.e2, f.e2);
  }

  // d·N and N·N. d moves with x for a point source: d_s = e₁, and e₁·N = 0.
  const Vec3 d_world = incident(x), d = R * d_world;
  const double moves = point_source_ ? 1.0 : 0.0;
  const Jet dN{d.dot(N),
               d.dot(N_s),
               d.dot(N_t),
               d.dot(N_ss) + moves * h11,
               d.dot(N_st) + moves * h12,
               d.dot(N_tt) + moves * h22};
  const Jet NN{NN0,
               2.0 * N.dot(N_s),
               2.0 * N.dot(N_t),
               2.0 * (N_s.dot(N_s) + N.dot(N_ss)),
               2.0 * (N_s.dot(N_t) + N.dot(N_st)),
               2.0 * (N_t.dot(N_t) + N.dot(N_tt))};
  const Jet kappa = 2.0 * (dN / NN);

  // Position, reflected direction (S3), arrival (S4).
  const Vec3 y = R * (x - receiver_->origin);
  const auto position = [&](int i) {
    return Jet{y[i], e1[i], e2[i], h11 * bend[i], h12 * bend[i], h22 * bend[i]};
  };
  const auto reflected = [&](int i) {
    const Jet N_i{N[i], N_s[i], N_t[i], N_ss[i], N_st[i], N_tt[i]};
    const Jet d_i{d[i],
                  moves * e1[i],
                  moves * e2[i],
                  moves * h11 * bend[i],
                  moves * h12 * bend[i],
                  moves * h22 * bend[i]};
    return d_i - kappa * N_i;
  };
  Jet D_m = reflected(2);
  if (D_m.v == 0.0) D_m.v = kParallel;
  const Jet lambda = -1.0 * (position(2) / D_m);
  const Jet q1 = position(0) + lambda * reflected(0), q2 = position(1) + lambda * reflected(1);
  f.lambda = lambda.v;
  f.facing = D_m.v;
  f.q = {q1.v, q2.v};
  f.q_s = {q1.s, q2.s};
  f.q_t = {q1.t, q2.t};

  // Magnification and its gradient (S5).
  f.a = q1.s * q2.t - q1.t * q2.s;
  const double a_s = q1.ss * q2.t + q1.s * q2.st - q1.st * q2.s - q1.t * q2.ss;
  const double a_t = q1.st * q2.t + q1.s * q2.tt - q1.tt * q2.s - q1.t * q2.st;
  f.grad_a = a_s * f.e1 + a_t * f.e2;

  // Flux density (S6) and cos α, through logarithmic derivatives of the smooth factors.
  const double dd = d_world.squaredNorm(), inverse_d = 1.0 / std::sqrt(dd);
  const double factor = -side_ * inverse_norm * inverse_d;
  f.cos_alpha = factor * dN.v;
  const Vec3 grad_dN = dN.s * f.e1 + dN.t * f.e2;
  const Vec3 grad_log_N = (0.5 / NN0) * (NN.s * f.e1 + NN.t * f.e2);
  const Vec3 grad_log_d = (moves / dd) * (d.dot(e1) * f.e1 + d.dot(e2) * f.e2);
  f.grad_cos = factor * (grad_dN - dN.v * (grad_log_N + grad_log_d));
  const double falloff = point_source_ ? strength_ * inverse_d * inverse_d : strength_;
  f.flux = falloff * f.cos_alpha;
  f.grad_flux = falloff * (f.grad_cos - 2.0 * f.cos_alpha * grad_log_d);

  f.finite = std::isfinite(f.a) && f.grad_a.allFinite() && std::isfinite(f.flux) &&
             f.grad_flux.allFinite() && f.q.allFinite();
  return f;
}

double FieldPoint::scale_of_a() const {
  const double uu = q_s.x() * q_s.x() + q_t.x() * q_t.x();
  const double vv = q_s.y() * q_s.y() + q_t.y() * q_t.y();
  return std::max(std::sqrt(uu * vv), kLeastScale * (uu + vv));
}

bool FieldPoint::looks_degenerate() const {
  const double stretch = q_s.squaredNorm() + q_t.squaredNorm();
  return std::abs(a) <= kDegenerateShare * stretch ||
         stretch <= kDegenerateShare * kDegenerateShare;
}

Vec2 FieldPoint::irradiance_gradient() const {
  // E_s = (σ_s − σ a_s/a)/|a|, then M⁻¹ from the right.
  const Vec3 grad = (grad_flux - (flux / a) * grad_a) / std::abs(a);
  const double E_s = grad.dot(e1), E_t = grad.dot(e2);
  return Vec2(E_s * q_t.y() - E_t * q_s.y(), E_t * q_s.x() - E_s * q_t.x()) / a;
}

}  // namespace caustic::solver
