#include "tests/support/reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "tests/support/reference_real.h"

namespace caustic::test {

namespace {

using Kind = ShapeSpec::Kind;

template <class T>
using V = std::array<T, 3>;

template <class T>
V<T> operator+(const V<T>& a, const V<T>& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
template <class T>
V<T> operator-(const V<T>& a, const V<T>& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
template <class T>
V<T> operator*(const T& k, const V<T>& a) { return {k * a[0], k * a[1], k * a[2]}; }
template <class T>
T dot(const V<T>& a, const V<T>& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
template <class T>
V<T> cross(const V<T>& a, const V<T>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class T>
T norm(const V<T>& a) { using std::sqrt; return sqrt(dot(a, a)); }
template <class T>
V<T> unit(const V<T>& a) { return T(1 / norm(a)) * a; }
template <class T>
V<T> from(const Vec3& a) { return {T(a.x()), T(a.y()), T(a.z())}; }
template <class T>
Vec3 rounded(const V<T>& a) {
  return {static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])};
}

template <class T>
struct Implicit {
  T value;
  V<T> gradient;
};

// g in the frame before the pose; signs as the contract has them (negative inside).
template <class T>
Implicit<T> implicit_local(const ShapeSpec& s, const V<T>& x) {
  using std::abs;
  using std::cos;
  using std::sin;
  using std::sqrt;
  if (s.kind == Kind::quadric) {
    const auto& c = s.coefficients;
    const T A(c[0]), B(c[1]), C(c[2]), D(c[3]), E(c[4]), F(c[5]), G(c[6]), H(c[7]), I(c[8]), J(c[9]);
    const T &X = x[0], &Y = x[1], &Z = x[2];
    return {A * X * X + B * Y * Y + C * Z * Z + 2 * (D * X * Y + E * X * Z + F * Y * Z) +
                2 * (G * X + H * Y + I * Z) + J,
            {2 * (A * X + D * Y + E * Z + G), 2 * (D * X + B * Y + F * Z + H),
             2 * (E * X + F * Y + C * Z + I)}};
  }
  const V<T> y = x - from<T>(s.point);
  if (s.kind == Kind::sphere) return {norm(y) - T(s.radius), unit(y)};
  if (s.kind == Kind::ellipsoid) {
    V<T> w, gradient{T(0), T(0), T(0)};
    for (int i = 0; i < 3; ++i) w[i] = dot(y, from<T>(s.rotation.col(i))) / T(s.semi_axes[i]);
    const T length = norm(w);
    for (int i = 0; i < 3; ++i) {
      const T k = w[i] / (T(s.semi_axes[i]) * length);
      gradient = gradient + k * from<T>(s.rotation.col(i));
    }
    return {length - 1, gradient};
  }
  const V<T> axis = unit(from<T>(s.axis));
  const T z = dot(y, axis);
  if (s.kind == Kind::plane) return {z, axis};
  const V<T> across = y - z * axis;
  const T rho = norm(across);
  if (s.kind == Kind::conic) {
    const T R(s.radius), e = 1 + T(s.second), w = 1 - e * rho * rho / (R * R), root = sqrt(w);
    if (s.aspheric.empty() && w < T(0.5)) {
      // Near the rim the height is a bad coordinate: radius as a function of height.
      const T radius = sqrt(2 * R * z - e * z * z), sign(s.radius > 0 ? 1 : -1);
      return {sign * (radius - rho), sign * (T((R - e * z) / radius) * axis - T(1 / rho) * across)};
    }
    T sag = rho * rho / (R * (1 + root)), slope_over_rho = 1 / (R * root);
    T power = rho * rho;
    for (std::size_t i = 0; i < s.aspheric.size(); ++i, power *= rho * rho) {
      sag += T(s.aspheric[i]) * power * rho * rho;
      slope_over_rho += T(s.aspheric[i]) * static_cast<int>(4 + 2 * i) * power;
    }
    return {z - sag, axis - slope_over_rho * across};
  }
  const V<T> out = T(1 / rho) * across;
  if (s.kind == Kind::revolution) {
    T radius(0), slope(0), power(1);  // powers summed upwards, where the program goes down by Horner
    for (std::size_t i = 0; i < s.profile.size(); ++i) {
      radius += T(s.profile[i]) * power;
      if (i + 1 < s.profile.size()) slope += T(s.profile[i + 1]) * static_cast<int>(i + 1) * power;
      power *= z / T(s.radius);
    }
    return {rho - radius, out - T(slope / T(s.radius)) * axis};
  }
  if (s.kind == Kind::cylinder) return {rho - T(s.radius), out};
  if (s.kind == Kind::cone) {
    const T c = cos(T(s.radius)), k = sin(T(s.radius));
    return {rho * c - abs(z) * k, c * out - T(z > 0 ? k : -k) * axis};
  }
  // Torus: distance to the circle of the tube's centres.
  const T off = rho - T(s.radius), distance = sqrt(off * off + z * z);
  return {distance - T(s.second), T(off / distance) * out + T(z / distance) * axis};
}

template <class T>
Implicit<T> implicit(const ShapeSpec& s, const V<T>& x) {
  const V<T> shifted = x - from<T>(s.pose.translation);
  const Mat3& R = s.pose.rotation;
  const V<T> c0 = from<T>(R.col(0)), c1 = from<T>(R.col(1)), c2 = from<T>(R.col(2));
  const auto local = implicit_local<T>(s, {dot(c0, shifted), dot(c1, shifted), dot(c2, shifted)});
  const V<T>& g = local.gradient;
  return {local.value, g[0] * c0 + g[1] * c1 + g[2] * c2};
}

// Any orthonormal pair across n.
template <class T>
std::array<V<T>, 2> tangents(const V<T>& n) {
  const int k = abs(n[0]) < 0.6 ? 0 : 1;
  V<T> e{T(0), T(0), T(0)};
  e[k] = T(1);
  const V<T> e1 = unit(e - n[k] * n);
  return {e1, cross(n, e1)};
}

// Differences: with 50 digits a step of 1e-16 leaves 1e-32; once more with 1e-10 leaves 1e-20.
const Real kStep("1e-16");
const Real kOuterStep("1e-10");

class FieldReference {
 public:
  explicit FieldReference(const ReferenceScene& scene) : scene_(scene) {
    u_ = unit(from<Real>(scene.receiver.u));
    const V<Real> v = from<Real>(scene.receiver.v);
    v_ = unit(v - dot(u_, v) * u_);
    m_ = cross(u_, v_);
    if (const auto* point = std::get_if<solver::PointLight>(&scene.light)) {
      source_ = from<Real>(point->position);
    } else {
      beam_ = unit(from<Real>(std::get<solver::CollimatedLight>(scene.light).direction));
    }
  }

  bool point_light() const { return scene_.light.index() == 0; }
  V<Real> omega(const V<Real>& x) const { return point_light() ? unit(x - source_) : beam_; }

  struct Arrival {
    std::array<Real, 2> q;
    V<Real> direction;
  };
  Arrival arrival(const V<Real>& x) const {
    const V<Real> n = unit(implicit<Real>(scene_.shape, x).gradient);
    const V<Real> in = omega(x);
    const V<Real> out = in - Real(2 * dot(in, n)) * n;
    const V<Real> y = x - from<Real>(scene_.receiver.origin);
    const Real tau = -dot(m_, y) / dot(m_, out);
    const V<Real> p = y + tau * out;
    return {{dot(u_, p), dot(v_, p)}, out};
  }

  /// Rows ∇q₁, ∇q₂, ∇g in ambient space.
  std::array<V<Real>, 3> path_matrix(const V<Real>& x) const {
    std::array<V<Real>, 3> K;
    for (int i = 0; i < 3; ++i) {
      V<Real> hi = x, lo = x;
      hi[i] += kStep;
      lo[i] -= kStep;
      const auto above = arrival(hi).q, below = arrival(lo).q;
      for (int j = 0; j < 2; ++j) K[j][i] = (above[j] - below[j]) / (2 * kStep);
    }
    K[2] = implicit<Real>(scene_.shape, x).gradient;
    return K;
  }
  Real magnification(const std::array<V<Real>, 3>& K) const {
    return scene_.side * dot(K[0], cross(K[1], K[2])) / norm(K[2]);
  }

  Real full_flux(const V<Real>& x) const {
    const Real rho(scene_.reflectance);
    if (point_light()) {
      const V<Real> d = x - source_;
      return rho * Real(std::get<solver::PointLight>(scene_.light).intensity) / dot(d, d);
    }
    return rho * Real(std::get<solver::CollimatedLight>(scene_.light).irradiance);
  }
  Real flux(const V<Real>& x) const {
    const V<Real> n = unit(implicit<Real>(scene_.shape, x).gradient);
    return -scene_.side * full_flux(x) * dot(omega(x), n);
  }

  ReferenceField field(const V<Real>& x) const {
    const auto K = path_matrix(x);
    const V<Real> n = unit(K[2]);
    const auto e = tangents(n);
    // First derivatives of q along e1, e2, and their changes.
    const auto along = [&](const std::array<V<Real>, 3>& k, int j, int i) { return dot(k[j], e[i]); };
    std::array<std::array<std::array<Real, 2>, 2>, 2> second;  // [q][i][k]
    V<Real> grad_a{Real(0), Real(0), Real(0)}, grad_flux = grad_a;
    Real bends = 0;
    for (int k = 0; k < 2; ++k) {
      const V<Real> hi = x + kOuterStep * e[k], lo = x - kOuterStep * e[k];
      const auto K_hi = path_matrix(hi), K_lo = path_matrix(lo);
      const Real two_h = 2 * kOuterStep;
      grad_a = grad_a + Real((magnification(K_hi) - magnification(K_lo)) / two_h) * e[k];
      grad_flux = grad_flux + Real((flux(hi) - flux(lo)) / two_h) * e[k];
      for (int i = 0; i < 2; ++i) {
        // The surface bends away from the tangent by −½ n h/|∇g|.
        const Real bend = (dot(K_hi[2], e[i]) - dot(K_lo[2], e[i])) / (two_h * norm(K[2]));
        bends += bend * bend;
        for (int j = 0; j < 2; ++j) {
          second[j][i][k] =
              (along(K_hi, j, i) - along(K_lo, j, i)) / two_h - bend * dot(K[j], n);
        }
      }
    }
    ReferenceField f;
    const auto at = arrival(x);
    f.q = {static_cast<double>(at.q[0]), static_cast<double>(at.q[1])};
    f.curvature = static_cast<double>(sqrt(bends));
    f.incidence = static_cast<double>(dot(m_, at.direction));
    f.a = static_cast<double>(magnification(K));
    Real squared[2];
    for (int j = 0; j < 2; ++j) {
      squared[j] = along(K, j, 0) * along(K, j, 0) + along(K, j, 1) * along(K, j, 1);
    }
    f.scale_of_a = static_cast<double>(sqrt(squared[0] * squared[1]));
    f.grad_a = rounded(grad_a);
    Real terms = 0;
    for (int k = 0; k < 2; ++k) {
      terms += abs(second[0][0][k] * along(K, 1, 1)) + abs(along(K, 0, 0) * second[1][1][k]) +
               abs(second[0][1][k] * along(K, 1, 0)) + abs(along(K, 0, 1) * second[1][0][k]);
    }
    f.scale_of_grad_a = static_cast<double>(terms);
    f.flux = static_cast<double>(flux(x));
    f.scale_of_flux = static_cast<double>(full_flux(x));
    f.grad_flux = rounded(grad_flux);
    f.scale_of_grad_flux = f.scale_of_flux * f.curvature;
    if (point_light()) f.scale_of_grad_flux += static_cast<double>(3 * full_flux(x) / norm(x - source_));
    return f;
  }

 private:
  const ReferenceScene& scene_;
  V<Real> u_, v_, m_, source_{}, beam_{};
};

}  // namespace

RealImplicit reference_implicit(const ShapeSpec& spec, const std::array<Real, 3>& x) {
  const auto at = implicit<Real>(spec, x);
  return {at.value, at.gradient};
}

ReferenceShape reference_shape(const ShapeSpec& spec, const Point& point) {
  const V<Real> x = from<Real>(point);
  const auto here = implicit<Real>(spec, x);
  const V<Real> n = unit(here.gradient);
  ReferenceShape r;
  r.distance = static_cast<double>(here.value / norm(here.gradient));
  r.normal = rounded(n);
  Mat3 derivative;  // ∂n, ambient
  for (int i = 0; i < 3; ++i) {
    V<Real> hi = x, lo = x;
    hi[i] += kStep;
    lo[i] -= kStep;
    const V<Real> change = unit(implicit<Real>(spec, hi).gradient) -
                           unit(implicit<Real>(spec, lo).gradient);
    derivative.col(i) = rounded(Real(1 / (2 * kStep)) * change);
  }
  r.curvature = derivative * (Mat3::Identity() - r.normal * r.normal.transpose());
  return r;
}

ReferenceRay::ReferenceRay(const ShapeSpec& spec, const geometry::Ray& ray)
    : spec_(&spec), ray_(ray) {}

long double ReferenceRay::value(long double t) const {
  using T = long double;
  const auto here =
      implicit<T>(*spec_, from<T>(ray_.origin) + t * from<T>(ray_.direction));
  return here.value / norm(here.gradient);
}

double ReferenceRay::distance(double t) const { return static_cast<double>(value(t)); }

std::vector<double> ReferenceRay::roots(double t0, double t1, int samples) const {
  using T = long double;
  std::vector<double> found;
  const auto bisect = [&](T a, T b, T fa) {
    for (int i = 0; i < 80; ++i) {
      const T middle = (a + b) / 2, f = value(middle);
      ((f > 0) == (fa > 0) ? a : b) = middle;
    }
    found.push_back(static_cast<double>((a + b) / 2));
  };
  // Sign changes on n intervals; true if there are any. `dips` collects the local minima of |f|
  // without a sign change: each may hide a pair of roots.
  const auto scan = [&](T a, T b, int n, std::vector<std::pair<T, T>>& dips) {
    std::vector<T> t(n + 1), f(n + 1);
    for (int i = 0; i <= n; ++i) {
      t[i] = a + (b - a) * i / n;
      f[i] = value(t[i]);
    }
    bool changes = false;
    for (int i = 0; i < n; ++i) {
      if (f[i] != f[i] || f[i + 1] != f[i + 1]) continue;
      if ((f[i] > 0) != (f[i + 1] > 0)) {
        bisect(t[i], t[i + 1], f[i]);
        changes = true;
      } else if (i > 0 && (f[i - 1] > 0) == (f[i] > 0) && std::abs(f[i]) < std::abs(f[i - 1]) &&
                 std::abs(f[i]) < std::abs(f[i + 1])) {
        dips.push_back({t[i - 1], t[i + 1]});
      }
    }
    return changes;
  };
  std::vector<std::pair<T, T>> dips;
  scan(t0, t1, samples, dips);
  for (auto [a, b] : dips) {
    for (int zoom = 0; zoom < 10; ++zoom) {
      std::vector<std::pair<T, T>> next;
      if (scan(a, b, 16, next) || next.empty()) break;
      std::tie(a, b) = next.front();
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

ReferenceField reference_field(const ReferenceScene& scene, const Point& x) {
  return FieldReference(scene).field(from<Real>(x));
}

double reference_irradiance(const ReferenceScene& scene, const Point& point) {
  const FieldReference reference(scene);
  const V<Real> x = from<Real>(point);
  const Real a = reference.magnification(reference.path_matrix(x));
  return static_cast<double>(reference.flux(x) / abs(a));
}

}  // namespace caustic::test
