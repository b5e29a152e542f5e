#include "solver/forward_map.h"

#include <cmath>

#include "geometry/jet.h"

namespace caustic::solver {

using geometry::Jet;
using geometry::JetOf;
using geometry::Mat3;
using Array2 = Eigen::Array2d;

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

Vec3 ForwardMap::incident(const Point& x) const {
  return point_source_ ? Vec3(x - source_) : source_;
}

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
  // second derivatives of N are multiples of Hĝ/|∇g|, others add the third derivative.
  const Mat3& R = to_receiver_;
  const Vec3 N = R * G, N_s = R * (g.hessian * f.e1), N_t = R * (g.hessian * f.e2);
  const Vec3 e1 = R * f.e1, e2 = R * f.e2, bend = N * (-1.0 / NN0);  // x_ij = h_ij · bend
  const Vec3 Hg = R * (g.hessian * G);
  const double h11 = e1.dot(N_s), h12 = e1.dot(N_t), h22 = e2.dot(N_t);
  const double k11 = -h11 / NN0, k12 = -h12 / NN0, k22 = -h22 / NN0;
  Vec3 N_ss = k11 * Hg, N_st = k12 * Hg, N_tt = k22 * Hg;

  // d·N and N·N. d moves with x for a point source: d_s = e₁, and e₁·N = 0.
  const Vec3 d_world = incident(x), d = R * d_world;
  const double moves = point_source_ ? 1.0 : 0.0;
  const double d_Hg = d.dot(Hg), N_Hg = N.dot(Hg);
  Jet dN{d.dot(N),
         d.dot(N_s),
         d.dot(N_t),
         k11 * d_Hg + moves * h11,
         k12 * d_Hg + moves * h12,
         k22 * d_Hg + moves * h22};
  Jet NN{NN0,
         2.0 * N.dot(N_s),
         2.0 * N.dot(N_t),
         2.0 * (N_s.dot(N_s) + k11 * N_Hg),
         2.0 * (N_s.dot(N_t) + k12 * N_Hg),
         2.0 * (N_t.dot(N_t) + k22 * N_Hg)};
  if (!quadratic_) {
    const auto add_third = [&](const Vec3& u, const Vec3& v, Vec3& N_uv, double& dN_uv,
                               double& NN_uv) {
      const Vec3 T_uv = R * shape().third_derivative(x, u, v);
      N_uv += T_uv;
      dN_uv += d.dot(T_uv);
      NN_uv += 2.0 * N.dot(T_uv);
    };
    add_third(f.e1, f.e1, N_ss, dN.ss, NN.ss);
    add_third(f.e1, f.e2, N_st, dN.st, NN.st);
    add_third(f.e2, f.e2, N_tt, dN.tt, NN.tt);
  }
  const Jet kappa = 2.0 * (dN / NN);

  // Position, reflected direction (S3), arrival (S4); along m, and along u and v together.
  const Vec3 y = R * (x - receiver_->origin);
  const auto along_m = [](const Vec3& w) { return w.z(); };
  const auto along_uv = [](const Vec3& w) -> Array2 { return w.head<2>(); };
  const auto position = [&](const auto& part) {
    using T = decltype(part(y));
    const T b = part(bend);
    return JetOf<T>{part(y), part(e1), part(e2), h11 * b, h12 * b, h22 * b};
  };
  const auto reflected = [&](const auto& part) {
    using T = decltype(part(y));
    const T b = moves * part(bend);
    const JetOf<T> part_of_d{part(d), moves * part(e1), moves * part(e2),
                             h11 * b, h12 * b,          h22 * b};
    return part_of_d -
           kappa * JetOf<T>{part(N), part(N_s), part(N_t), part(N_ss), part(N_st), part(N_tt)};
  };
  Jet D_m = reflected(along_m);
  if (D_m.v == 0.0) D_m.v = kParallel;
  const Jet lambda = -1.0 * (position(along_m) / D_m);
  const JetOf<Array2> q = position(along_uv) + lambda * reflected(along_uv);
  f.lambda = lambda.v;
  f.facing = D_m.v;
  f.q = q.v;
  f.q_s = q.s;
  f.q_t = q.t;

  // Magnification and its gradient (S5).
  const auto det = [](const Array2& a, const Array2& b) { return a.x() * b.y() - a.y() * b.x(); };
  f.a = det(q.s, q.t);
  const double a_s = det(q.ss, q.t) + det(q.s, q.st);
  const double a_t = det(q.st, q.t) + det(q.s, q.tt);
  f.grad_a = a_s * f.e1 + a_t * f.e2;

  // Flux density (S6) and cos α, through logarithmic derivatives of the smooth factors.
  const double dd = d_world.squaredNorm(), inverse_d = 1.0 / std::sqrt(dd);
  const double factor = -side_ * inverse_norm * inverse_d;
  f.cos_alpha = factor * dN.v;
  const double log_d_s = moves * d.dot(e1) / dd, log_d_t = moves * d.dot(e2) / dd;
  const double cos_s = factor * (dN.s - dN.v * (0.5 * NN.s / NN0 + log_d_s));
  const double cos_t = factor * (dN.t - dN.v * (0.5 * NN.t / NN0 + log_d_t));
  f.grad_cos = cos_s * f.e1 + cos_t * f.e2;
  const double falloff = point_source_ ? strength_ * inverse_d * inverse_d : strength_;
  const double flux_s = falloff * (cos_s - 2.0 * f.cos_alpha * log_d_s);
  const double flux_t = falloff * (cos_t - 2.0 * f.cos_alpha * log_d_t);
  f.flux = falloff * f.cos_alpha;
  f.grad_flux = flux_s * f.e1 + flux_t * f.e2;

  // A sum is finite only if its terms are.
  f.finite = std::isfinite(f.a + a_s + a_t + f.flux + flux_s + flux_t + f.q.sum());
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
