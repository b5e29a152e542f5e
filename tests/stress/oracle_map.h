// The map from rays of the light to the receiver, on any number type: roots by Newton's method,
// Snell with unit vectors, irradiance as the share of light in a thin bundle over the area that it
// arrives on. No derivative but differences, no tangent frame, no formula of the program.
#pragma once

#include <boost/multiprecision/eigen.hpp>
#include <optional>
#include <type_traits>
#include <vector>

#include "tests/stress/oracle_scene.h"
#include "tests/support/reference_real.h"

namespace caustic::stress {

using Family = std::vector<int>;

template <class T>
class PathMap {
 public:
  using Vec = Eigen::Matrix<T, 3, 1>;
  using Mat = Eigen::Matrix<T, 3, 3>;
  using Expression = test::ExpressionOracle<T>;
  struct Ray {
    Vec o, w;
  };
  struct Arrival {
    T u, v, share;
  };
  /// What a bundle about one ray shows: q, and ∂q by the bundle's two coordinates.
  struct Bundle {
    T u, v, share;
    T du[2], dv[2];
    T det() const { return du[0] * dv[1] - du[1] * dv[0]; }
  };

  /// How following a path ends: at the receiver; without meeting its next surface; where all is
  /// reflected; with the receiver behind.
  enum class Fate { arrives, misses, reflected, behind };

  explicit PathMap(const OracleScene& scene) : scene_(scene) {
    const Vec u = wide(scene.receiver.u), v = wide(scene.receiver.v);
    u_ = u.normalized();
    v_ = Vec(v - u_ * u_.dot(v)).normalized();
    m_ = u_.cross(v_);
    for (const OracleSurface& s : scene.surfaces)
      expressions_.push_back(s.expression ? std::make_unique<Expression>(s.shape.expression)
                                          : nullptr);
  }

  static Vec wide(const Vec3& a) { return {T(a[0]), T(a[1]), T(a[2])}; }

  T value(int surface, const Vec& x, Vec& gradient) const {
    const OracleSurface& s = scene_.surfaces[surface];
    if (expressions_[surface]) {
      // An error of the step's square, and of rounding over the step.
      const T unit(s.shape.unit), step = T(kPartial * T((s.hi - s.lo).minCoeff())) / unit;
      const Mat R = s.shape.pose.rotation.template cast<T>();
      const Vec y = R.transpose() * (x - wide(s.shape.pose.translation)) / unit;
      const std::array<T, 3> at{y[0], y[1], y[2]};
      Vec slope;
      for (int i = 0; i < 3; ++i) slope[i] = expressions_[surface]->partial(at, i, step) / unit;
      gradient = R * slope;
      return (*expressions_[surface])(at);
    }
    const auto at = test::reference_implicit(s.shape, std::array<T, 3>{x[0], x[1], x[2]});
    gradient = Vec(at.gradient[0], at.gradient[1], at.gradient[2]);
    return at.value;
  }

  /// The nearest point of the surface, for x close to it.
  Vec project(int surface, Vec x) const {
    for (int i = 0; i < 8; ++i) {
      Vec g;
      const T value_here = value(surface, x, g);
      x -= g * T(value_here / g.squaredNorm());
    }
    return x;
  }

  /// The light's ray through x, and how far it has gone there.
  std::pair<Ray, T> ray_through(const Vec& x) const {
    if (scene_.point_light()) {
      const Vec o = wide(std::get<solver::PointLight>(scene_.light).position), d = x - o;
      return {{o, d.normalized()}, d.norm()};
    }
    const Vec w = wide(std::get<solver::CollimatedLight>(scene_.light).direction).normalized();
    const T back(scene_.size);
    return {{x - back * w, w}, back};
  }

  /// Onto what the path meets next to these distances.
  Fate follow(const Family& family, Ray ray, const std::vector<T>& near, Arrival& out,
              std::vector<Vec>* hits = nullptr) const {
    out.share = T(1);
    if (near.size() < family.size()) return Fate::misses;
    for (std::size_t i = 0; i < family.size(); ++i) {
      T t = near[i];
      Vec g;
      bool last_one = false;  // the step after a small one leaves rounding alone
      for (int k = 0; k < 20; ++k) {
        const T height = value(family[i], ray.o + t * ray.w, g), step = height / g.dot(ray.w);
        t -= step;
        if (!(step == step)) return Fate::misses;
        if (last_one) break;
        last_one = abs_of(step) <= kNearlySettled * (abs_of(t) + T(scene_.size) * T(1e-3));
      }
      if (!last_one) return Fate::misses;
      ray.o += t * ray.w;
      value(family[i], ray.o, g);
      if (hits) hits->push_back(ray.o);
      if (!bend(scene_.surfaces[family[i]].optics, g.normalized(), ray.w, out.share))
        return Fate::reflected;
    }
    const Vec y = ray.o - wide(scene_.receiver.origin);
    const T tau = -m_.dot(y) / m_.dot(ray.w);
    const Vec p = y + tau * ray.w;
    out.u = u_.dot(p), out.v = v_.dot(p);
    return tau >= -T(1e-9) * T(scene_.size) ? Fate::arrives : Fate::behind;
  }

  /// Direction and share after a hop, n along ∇g; false if all is reflected that should pass.
  static bool bend(const solver::Optics& optics, const Vec& n, Vec& w, T& share) {
    using std::sqrt;
    const T c = n.dot(w);
    if (optics.kind == solver::Optics::Kind::mirror) {
      share *= optics.metal ? metal_reflectance(*optics.metal, abs_of(c)) : T(optics.reflectance);
      w = Vec(w - T(2 * c) * n).normalized();
      return true;
    }
    if (optics.kind != solver::Optics::Kind::refract) return false;
    const T from(c < 0 ? optics.index_outside : optics.index_inside);
    const T to(c < 0 ? optics.index_inside : optics.index_outside);
    const Vec across = T(from / to) * (w - c * n);
    const T left = 1 - across.squaredNorm();
    if (!(left > 0)) return false;
    const T cos_out = sqrt(left), cos_in = abs_of(c);
    if (optics.fresnel) {
      const T s = (from * cos_in - to * cos_out) / (from * cos_in + to * cos_out);
      const T p = (to * cos_in - from * cos_out) / (to * cos_in + from * cos_out);
      share *= 1 - (s * s + p * p) / 2;
    }
    w = Vec(across + (c < 0 ? T(-cos_out) : cos_out) * n).normalized();
    return true;
  }

  /// The bundle about the ray through x; of its axes b1 × b2 points to the light, so that its
  /// orientation is that of the lit side of whatever it falls on.
  std::optional<Bundle> bundle(const Family& family, const Vec& x, std::vector<T> near) const {
    const auto [ray, gone] = ray_through(x);
    if (!near.empty()) near[0] = gone;
    const int k = abs_of(ray.w[0]) < T(0.6) ? 0 : 1;
    const Vec b1 = Vec(Vec::Unit(k) - ray.w[k] * ray.w).normalized(), b2 = b1.cross(ray.w);
    const auto at = [&](const T& alpha, const T& beta, Arrival& arrival) {
      Ray moved = ray;
      if (scene_.point_light())
        moved.w = Vec(ray.w + alpha * b1 + beta * b2).normalized();
      else
        moved.o += alpha * b1 + beta * b2;
      return follow(family, moved, near, arrival) == Fate::arrives;
    };
    Bundle out;
    Arrival middle, hi, lo;
    if (!at(T(0), T(0), middle)) return std::nullopt;
    out.u = middle.u, out.v = middle.v, out.share = middle.share;
    T h = scene_.point_light() ? T(kStep) : T(kStep * T(scene_.size));
    // Where the image is stretched beyond measure the bundle is made thinner, or grazing rays miss.
    for (int attempt = 0; attempt < 4; ++attempt) {
      bool arrive = true;
      T widest(0);
      for (int i = 0; i < 2; ++i) {
        const T a = i == 0 ? h : T(0), b = i == 0 ? T(0) : h;
        arrive = arrive && at(a, b, hi) && at(-a, -b, lo);
        out.du[i] = (hi.u - lo.u) / (2 * h), out.dv[i] = (hi.v - lo.v) / (2 * h);
        widest = std::max({widest, abs_of(out.du[i]), abs_of(out.dv[i])});
      }
      if (arrive && widest * h <= T(1e-5) * T(scene_.size)) return out;
      h = arrive ? T(T(1e-6) * T(scene_.size) / widest) : T(h * T(1e-3));
      if (arrive && attempt == 2) return out;
    }
    return std::nullopt;
  }

  /// W/sr, or W/m² across the beam.
  T strength() const {
    return scene_.point_light() ? T(std::get<solver::PointLight>(scene_.light).intensity)
                                : T(std::get<solver::CollimatedLight>(scene_.light).irradiance);
  }

 private:
  static constexpr bool kWide = !std::is_same_v<T, Long>;
  inline static const T kStep = kWide ? T(1e-18) : T(1e-6);
  inline static const T kPartial = kWide ? T(1e-16) : T(1e-6);
  inline static const T kNearlySettled = kWide ? T(1e-30) : T(1e-12);

  static T abs_of(const T& a) { return a < 0 ? T(-a) : a; }

  // Born & Wolf §14.2: √(m² − sin² i) = a − ib.
  static T metal_reflectance(const std::complex<double>& m, const T& cosine) {
    using std::sqrt;
    const T n(m.real()), k(m.imag()), s2 = 1 - cosine * cosine, d = n * n - k * k - s2;
    const T root = sqrt(T(d * d + 4 * n * n * k * k)), aa = (root + d) / 2, bb = (root - d) / 2;
    const T a = sqrt(aa), t = s2 / cosine, cc = cosine * cosine;
    const T across = (aa + bb - 2 * a * cosine + cc) / (aa + bb + 2 * a * cosine + cc);
    const T along = across * (aa + bb - 2 * a * t + t * t) / (aa + bb + 2 * a * t + t * t);
    return (across + along) / 2;
  }

  const OracleScene& scene_;
  Vec u_, v_, m_;
  std::vector<std::unique_ptr<Expression>> expressions_;
};

}  // namespace caustic::stress
