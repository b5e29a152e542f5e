#include "solver/forward_map.h"

#include <cmath>

#include "geometry/jet.h"

namespace caustic::solver {

using geometry::Jet;
using geometry::JetOf;
using geometry::Mat3;
using Array2 = Eigen::Array2d;

ForwardMap::ForwardMap(const OpticalSystem& system, const Hops& hops, bool all_third_derivatives)
    : system_(&system),
      hops_(hops),
      all_third_derivatives_(all_third_derivatives),
      scale_(system.diameter()) {
  single_mirror_ = hops.size() == 1 && mirror().optics.kind == Optics::Kind::mirror &&
                   mirror().optics.constant_share();
  quadratic_ = !all_third_derivatives && shape().at_most_quadratic();
  if (const auto* point = std::get_if<PointLight>(&system.light())) {
    point_source_ = true;
    source_ = point->position;
    strength_ = point->intensity;
  } else {
    const auto& beam = std::get<CollimatedLight>(system.light());
    point_source_ = false;
    source_ = beam.direction;
    strength_ = beam.irradiance;
  }
  for (int j = 0; j < hop_count(); ++j) {
    const Optics& optics = surface(j).optics;
    if (optics.constant_share()) strength_ *= optics.share(hops_[j].side, 1.0).value;
  }
  to_receiver_ << receiver().u.transpose(), receiver().v.transpose(), receiver().m.transpose();
  side_ =
      hops.empty() ? (receiver().m.dot(incident(receiver().origin)) < 0.0 ? 1 : -1) : hops[0].side;
}

Vec3 ForwardMap::incident(const Point& x) const {
  return point_source_ ? Vec3(x - source_) : source_;
}

// Where the ray that leaves a hop meets the surface of the next one.
std::optional<double> ForwardMap::hit_after(int hop, const geometry::Ray& ray,
                                            const double* guess) const {
  const bool returns = hops_[hop + 1].surface == hops_[hop].surface;
  return next_hit(surface(hop + 1), hops_[hop + 1].side, ray,
                  returns ? least_return(ray, scale_) : 0.0, guess);
}

bool ForwardMap::follow(const Point& x, std::vector<Point>& hits, Vec3& direction) const {
  hits.assign(1, x);
  direction = incident(x);
  Vec3 N;
  for (int j = 0; j < hop_count(); ++j) {
    if (j > 0) {
      const geometry::Ray ray{hits.back(), direction};
      const auto tau = hit_after(j - 1, ray, nullptr);
      if (!tau) return false;
      hits.push_back(ray.at(*tau));
    }
    surface(j).shape->value_gradient(hits.back(), N);
    const auto on = bend(surface(j).optics, hops_[j].side, direction, N);
    direction = on.value_or(Vec3::Zero());
    if (!on) return false;
  }
  return true;
}

NearMiss ForwardMap::near_miss(const Point& x) const {
  thread_local std::vector<Point> hits;
  Vec3 direction;
  if (follow(x, hits, direction) || direction.isZero(0.0)) return {};
  return {static_cast<int>(hits.size()), hits.back(), direction};
}

Vec2 ForwardMap::arrival(const Point& x) const {
  thread_local std::vector<Point> hits;
  Vec3 direction;
  if (!follow(x, hits, direction)) return Vec2::Constant(std::nan(""));
  const Vec3 D = to_receiver_ * direction, y = to_receiver_ * (hits.back() - receiver().origin);
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

// What is known at the first hit before the path is followed.
struct ForwardMap::Start {
  geometry::SurfaceDerivatives g;
  Vec3 H1, H2, HG;     // Hessian times e1, e2 and the gradient
  Vec3 d;              // incident, unnormalised
  double NN, inverse_norm;
};

namespace {

// Arrival on the receiver (S4) and magnification with its gradient (S5), from the last hit and the
// direction there as jets along m and along (u, v).
[[gnu::always_inline]] inline void arrive(const Jet& x_m, Jet D_m, const JetOf<Array2>& x_uv,
                                          const JetOf<Array2>& D_uv, FieldPoint& f) {
  if (D_m.v == 0.0) D_m.v = kParallel;
  const Jet lambda = -1.0 * (x_m / D_m);
  const JetOf<Array2> q = x_uv + lambda * D_uv;
  f.lambda = lambda.v;
  f.facing = D_m.v;
  f.q = q.v;
  f.q_s = q.s;
  f.q_t = q.t;
  const auto det = [](const Array2& a, const Array2& b) { return a.x() * b.y() - a.y() * b.x(); };
  f.a = det(q.s, q.t);
  const double a_s = det(q.ss, q.t) + det(q.s, q.st);
  const double a_t = det(q.st, q.t) + det(q.s, q.tt);
  f.grad_a = a_s * f.e1 + a_t * f.e2;
}

// First derivatives along the surface as a vector.
Vec3 along(const FieldPoint& f, double s, double t) { return s * f.e1 + t * f.e2; }

}  // namespace

// The direct light (S80): x itself is on the receiver, and M an isometry.
void ForwardMap::arrive_at_once(const Start& start, FieldPoint& f) const {
  f.lambda = 1.0;
  f.facing = receiver().m.dot(start.d);
  f.q = (to_receiver_ * (f.x - receiver().origin)).head<2>();
  f.q_s = (to_receiver_ * f.e1).head<2>();
  f.q_t = (to_receiver_ * f.e2).head<2>();
  f.a = side_;
  f.grad_a = Vec3::Zero();
}

// One mirror. Receiver axes throughout; for quadrics the second derivatives of N are multiples of
// Hĝ/|∇g|, others add the third derivative.
[[gnu::always_inline]] inline void ForwardMap::reflect_once(const Start& start,
                                                            FieldPoint& f) const {
  const Mat3& R = to_receiver_;
  const Vec3& G = start.g.gradient;
  const double NN0 = start.NN;
  const Vec3 N = R * G, N_s = R * start.H1, N_t = R * start.H2;
  const Vec3 e1 = R * f.e1, e2 = R * f.e2, bend = N * (-1.0 / NN0);  // x_ij = h_ij · bend
  const Vec3 Hg = R * start.HG;
  const double h11 = e1.dot(N_s), h12 = e1.dot(N_t), h22 = e2.dot(N_t);
  const double k11 = -h11 / NN0, k12 = -h12 / NN0, k22 = -h22 / NN0;
  Vec3 N_ss = k11 * Hg, N_st = k12 * Hg, N_tt = k22 * Hg;

  // d·N and N·N. d moves with x for a point source: d_s = e₁, and e₁·N = 0.
  const Vec3 d = R * start.d;
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
    const geometry::ThirdDerivatives T = shape().third_derivatives(f.x, f.e1, f.e2);
    const auto add_third = [&](const Vec3& T_in_world, Vec3& N_uv, double& dN_uv, double& NN_uv) {
      const Vec3 T_uv = R * T_in_world;
      N_uv += T_uv;
      dN_uv += d.dot(T_uv);
      NN_uv += 2.0 * N.dot(T_uv);
    };
    add_third(T.uu, N_ss, dN.ss, NN.ss);
    add_third(T.uv, N_st, dN.st, NN.st);
    add_third(T.vv, N_tt, dN.tt, NN.tt);
  }
  const Jet kappa = 2.0 * (dN / NN);

  const Vec3 y = R * (f.x - receiver().origin);
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
  arrive(position(along_m), reflected(along_m), position(along_uv), reflected(along_uv), f);
}

// Any family, in world axes.
bool ForwardMap::pass_all_hops(const Start& start, const Hit* near, FieldPoint& f) const {
  const double inverse_NN = -1.0 / start.NN;
  const Vec3 bend_of_x = start.g.gradient * inverse_NN;
  const Vec3 &H1 = start.H1, &H2 = start.H2;
  RayJet ray;
  ray.x = {f.x,
           f.e1,
           f.e2,
           f.e1.dot(H1) * bend_of_x,
           f.e1.dot(H2) * bend_of_x,
           f.e2.dot(H2) * bend_of_x};
  const Vec3 still = Vec3::Zero();
  ray.d = point_source_
              ? VecJet{start.d, ray.x.s, ray.x.t, ray.x.ss, ray.x.st, ray.x.tt}
              : VecJet{start.d, still, still, still, still, still};

  const int count = hop_count();
  auto hits = std::make_shared<Hit[]>(count);
  auto at = start.g;
  Vec3 grad_share = Vec3::Zero();
  for (int j = 0; j < count; ++j) {
    const geometry::Surface& surface_shape = *surface(j).shape;
    Hit& hit = hits[j];
    hit.tau = 0.0;
    if (j > 0) {
      const geometry::Ray line{ray.x.v, ray.d.v};
      const auto tau = hit_after(j - 1, line, near ? &near[j].tau : nullptr);
      if (!tau) return false;
      hit.tau = *tau;
      at = surface_shape.derivatives(line.at(*tau));
      transfer(ray, *tau, at);
    }
    hit.y = ray.x.v;
    hit.y_s = ray.x.s;
    hit.y_t = ray.x.t;
    Bounce bounce;
    const Optics& optics = surface(j).optics;
    const bool third = all_third_derivatives_ || !surface_shape.at_most_quadratic();
    if (!bend(optics, hops_[j].side, normal_jet(surface_shape, at, ray.x, third), ray, bounce)) {
      return false;
    }
    hit.cosine = bounce.cosine.v;
    hit.grad_cosine = along(f, bounce.cosine.s, bounce.cosine.t);
    hit.headroom = bounce.headroom.v;
    hit.grad_headroom = along(f, bounce.headroom.s, bounce.headroom.t);
    if (!optics.constant_share()) {
      const Share share = optics.share(hops_[j].side, hit.cosine);
      grad_share = share.value * grad_share + (f.share * share.slope) * hit.grad_cosine;
      f.share *= share.value;
    }
  }
  f.hits = std::move(hits);
  f.grad_flux = f.share * f.grad_flux + f.flux * grad_share;
  f.flux *= f.share;

  const Mat3& R = to_receiver_;
  const auto turned = [&](const VecJet& w) {
    return VecJet{R * w.v, R * w.s, R * w.t, R * w.ss, R * w.st, R * w.tt};
  };
  const auto part_m = [](const VecJet& w) {
    return Jet{w.v.z(), w.s.z(), w.t.z(), w.ss.z(), w.st.z(), w.tt.z()};
  };
  const auto part_uv = [](const VecJet& w) {
    return JetOf<Array2>{w.v.head<2>(),  w.s.head<2>(),  w.t.head<2>(),
                         w.ss.head<2>(), w.st.head<2>(), w.tt.head<2>()};
  };
  ray.x.v -= receiver().origin;
  const VecJet x = turned(ray.x), d = turned(ray.d);
  arrive(part_m(x), part_m(d), part_uv(x), part_uv(d), f);
  return true;
}

FieldPoint ForwardMap::evaluate(const Point& x, const Hit* near) const {
  FieldPoint f;
  f.x = x;
  Start start;
  start.g = shape().derivatives(x);
  start.d = incident(x);
  const Vec3& G = start.g.gradient;
  start.NN = G.squaredNorm();
  start.inverse_norm = 1.0 / std::sqrt(start.NN);
  f.n = (side() * start.inverse_norm) * G;
  const geometry::Frame frame(f.n);
  f.e1 = frame.e1;
  f.e2 = frame.e2;

  const Mat3& H = start.g.hessian;
  start.H1 = H * f.e1;
  start.H2 = H * f.e2;
  start.HG = H * G;

  // Flux density (S6) and cos α, through logarithmic derivatives of the smooth factors.
  const Vec3& d = start.d;
  const double moves = point_source_ ? 1.0 : 0.0;
  const double dN = d.dot(G), dd = d.squaredNorm(), inverse_d = 1.0 / std::sqrt(dd);
  const double factor = -side() * start.inverse_norm * inverse_d, inverse_NN = 1.0 / start.NN;
  const double log_d_s = moves * d.dot(f.e1) / dd, log_d_t = moves * d.dot(f.e2) / dd;
  const double log_N_s = start.HG.dot(f.e1) * inverse_NN, log_N_t = start.HG.dot(f.e2) * inverse_NN;
  f.cos_alpha = factor * dN;
  const double cos_s = factor * (d.dot(start.H1) - dN * (log_N_s + log_d_s));
  const double cos_t = factor * (d.dot(start.H2) - dN * (log_N_t + log_d_t));
  f.grad_cos = along(f, cos_s, cos_t);
  const double falloff = point_source_ ? strength_ * inverse_d * inverse_d : strength_;
  const double flux_s = falloff * (cos_s - 2.0 * f.cos_alpha * log_d_s);
  const double flux_t = falloff * (cos_t - 2.0 * f.cos_alpha * log_d_t);
  f.flux = falloff * f.cos_alpha;
  f.grad_flux = along(f, flux_s, flux_t);

  if (hops_.empty()) {
    arrive_at_once(start, f);
  } else if (single_mirror_) {
    reflect_once(start, f);
  } else if (!pass_all_hops(start, near, f)) {
    return f;
  }
  // A sum is finite only if its terms are.
  f.finite = std::isfinite(f.a + f.grad_a.sum() + f.flux + f.grad_flux.sum() + f.q.sum());
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
