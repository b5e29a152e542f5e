#include "tests/support/reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "tests/support/reference_real.h"
#include "tests/support/expression_oracle.h"

namespace caustic::test {

namespace {

using Kind = ShapeSpec::Kind;

template <class T>
using V = std::array<T, 3>;

template <class T>
V<T> operator+(const V<T>& a, const V<T>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <class T>
V<T> operator-(const V<T>& a, const V<T>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class T>
V<T> operator*(const T& k, const V<T>& a) {
  return {k * a[0], k * a[1], k * a[2]};
}
template <class T>
T dot(const V<T>& a, const V<T>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class T>
V<T> cross(const V<T>& a, const V<T>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class T>
T norm(const V<T>& a) {
  using std::sqrt;
  return sqrt(dot(a, a));
}
template <class T>
V<T> unit(const V<T>& a) {
  return T(1 / norm(a)) * a;
}
template <class T>
V<T> from(const Vec3& a) {
  return {T(a.x()), T(a.y()), T(a.z())};
}
template <class T>
Vec3 rounded(const V<T>& a) {
  return {static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])};
}

template <class T>
struct Implicit {
  T value;
  V<T> gradient;
};

// ---- Height fields --------------------------------------------------------------------------------

// A value with its slopes in x and y.
template <class T>
struct Sloped {
  T v, x, y;
  friend Sloped operator+(const Sloped& a, const Sloped& b) { return {a.v + b.v, a.x + b.x, a.y + b.y}; }
  friend Sloped operator-(const Sloped& a, const Sloped& b) { return {a.v - b.v, a.x - b.x, a.y - b.y}; }
  friend Sloped operator*(const Sloped& a, const Sloped& b) {
    return {a.v * b.v, a.x * b.v + a.v * b.x, a.y * b.v + a.v * b.y};
  }
  friend Sloped operator*(const T& k, const Sloped& a) { return {k * a.v, k * a.x, k * a.y}; }
};

// Zernike's polynomial by Jacobi's recurrence, ρ^m P_k^(0,m)(2ρ² − 1) with k = (n − m)/2, and powers of
// x + iy, where the program has sums of integers.
template <class T>
Sloped<T> zernike_value(int index, const Sloped<T>& x, const Sloped<T>& y) {
  using std::sqrt;
  int n = 0;
  while ((n + 1) * (n + 2) / 2 <= index) ++n;
  const int m = 2 * index - n * (n + 2), order = std::abs(m), k = (n - order) / 2;
  const Sloped<T> one{T(1), T(0), T(0)};
  Sloped<T> re = one, im{T(0), T(0), T(0)};
  for (int i = 0; i < order; ++i) std::tie(re, im) = std::pair(re * x - im * y, re * y + im * x);
  const Sloped<T> t = T(2) * (x * x + y * y) - one;
  Sloped<T> before = one, p = one;
  for (int i = 1; i <= k; ++i) {
    const int s = 2 * i + order;
    Sloped<T> next = one + (T(order + 2) / 2) * (t - one);
    if (i > 1) {
      const Sloped<T> linear = T(s - 1) * (T(s * (s - 2)) * t - T(order * order) * one);
      next = T(T(1) / (2 * i * (i + order) * (s - 2))) *
             (linear * p - T(2 * (i - 1) * (i + order - 1) * s) * before);
    }
    before = p;
    p = next;
  }
  return T(sqrt(T((m == 0 ? 1 : 2) * (n + 1)))) * (p * (m < 0 ? im : re));
}

// Truncated powers 1, w, …, w⁵, (w − k)₊⁵ at the inner knots, where the program has B-splines; w = u/h − 1
// in [−1, 1] over n samples. Slopes are in u.
template <class T>
std::vector<T> truncated_powers(int n, const T& u, bool slope) {
  std::vector<T> b;
  const T h = T(n - 1) / 2;
  const auto add = [&](const T& w, int p) {
    T power(1);
    for (int i = slope ? 1 : 0; i < p; ++i) power *= w;
    b.push_back(slope ? T(p * power / h) : power);
  };
  for (int p = 0; p <= 5; ++p) add(u / h - 1, p);
  for (int k = 3; k <= n - 4; ++k) add(u > k ? T((u - k) / h) : T(0), 5);
  return b;
}

template <class T>
using TableOf = std::vector<std::vector<T>>;
using Table = TableOf<Real>;

// X with A X = B, Gauss with pivots.
Table solved(Table A, Table B) {
  const std::size_t n = A.size();
  for (std::size_t k = 0; k < n; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k; i < n; ++i) {
      if (abs(A[i][k]) > abs(A[pivot][k])) pivot = i;
    }
    std::swap(A[k], A[pivot]);
    std::swap(B[k], B[pivot]);
    for (std::size_t i = 0; i < n; ++i) {
      if (i == k) continue;
      const Real factor = A[i][k] / A[k][k];
      for (std::size_t j = k; j < n; ++j) A[i][j] -= factor * A[k][j];
      for (std::size_t j = 0; j < B[i].size(); ++j) B[i][j] -= factor * B[k][j];
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (Real& b : B[k]) b /= A[k][k];
  }
  return B;
}

// Coefficients of the tensor product of truncated powers through the samples: [along u][along v].
Table interpolated(const geometry::HeightGrid& grid) {
  const auto collocation = [](int n) {
    Table A;
    for (int i = 0; i < n; ++i) A.push_back(truncated_powers<Real>(n, Real(i), false));
    return A;
  };
  Table samples(grid.ny);
  for (int j = 0; j < grid.ny; ++j) {
    for (int i = 0; i < grid.nx; ++i) samples[j].push_back(grid.values[j * grid.nx + i]);
  }
  const Table along_v = solved(collocation(grid.ny), samples);
  Table turned(grid.nx);
  for (const auto& row : along_v) {
    for (int i = 0; i < grid.nx; ++i) turned[i].push_back(row[i]);
  }
  return solved(collocation(grid.nx), turned);
}

template <class T>
const TableOf<T>& spline_table(const geometry::HeightGrid& grid) {
  static std::map<std::vector<double>, TableOf<T>> known;
  const auto [entry, fresh] = known.try_emplace(grid.values);
  if (fresh) {
    for (const auto& row : interpolated(grid)) {
      entry->second.emplace_back();
      for (const Real& c : row) entry->second.back().push_back(static_cast<T>(c));
    }
  }
  return entry->second;
}

// Height and slopes at (x, y).
template <class T>
std::array<T, 3> height(const ShapeSpec& s, const T& x, const T& y) {
  std::array<T, 3> h{T(0), T(0), T(0)};
  if (s.kind == Kind::sag) {
    const auto power = [](const T& t, int p) {
      T product(1);
      for (int i = 0; i < p; ++i) product *= t;
      return product;
    };
    for (const auto& [i, j, c] : s.terms) {
      h[0] += T(c) * power(x, i) * power(y, j);
      if (i > 0) h[1] += T(c) * i * power(x, i - 1) * power(y, j);
      if (j > 0) h[2] += T(c) * j * power(x, i) * power(y, j - 1);
    }
  } else if (s.kind == Kind::zernike) {
    const T k = 1 / T(s.radius);
    for (const auto& [index, c] : s.zernike) {
      const auto z = zernike_value<T>(index, {x * k, k, T(0)}, {y * k, T(0), k});
      h[0] += T(c) * z.v;
      h[1] += T(c) * z.x;
      h[2] += T(c) * z.y;
    }
  } else {
    const auto& grid = s.grid;
    const T du = T(grid.nx - 1) / (T(grid.max.x()) - T(grid.min.x()));
    const T dv = T(grid.ny - 1) / (T(grid.max.y()) - T(grid.min.y()));
    const T u = (x - T(grid.min.x())) * du, v = (y - T(grid.min.y())) * dv;
    const auto bu = truncated_powers<T>(grid.nx, u, false), bv = truncated_powers<T>(grid.ny, v, false);
    const auto su = truncated_powers<T>(grid.nx, u, true), sv = truncated_powers<T>(grid.ny, v, true);
    const auto& table = spline_table<T>(grid);
    for (int i = 0; i < grid.nx; ++i) {
      T along_v(0), slope_v(0);
      for (int j = 0; j < grid.ny; ++j) {
        along_v += table[i][j] * bv[j];
        slope_v += table[i][j] * sv[j];
      }
      h[0] += bu[i] * along_v;
      h[1] += su[i] * along_v * du;
      h[2] += bu[i] * slope_v * dv;
    }
  }
  return h;
}

// g in the frame before the pose; signs as the contract has them (negative inside).
template <class T>
Implicit<T> implicit_local(const ShapeSpec& s, const V<T>& x) {
  using std::abs;
  using std::cos;
  using std::sin;
  using std::sqrt;
  if (s.kind == Kind::quadric) {
    const auto& c = s.coefficients;
    const T A(c[0]), B(c[1]), C(c[2]), D(c[3]), E(c[4]), F(c[5]), G(c[6]), H(c[7]), I(c[8]),
        J(c[9]);
    const T &X = x[0], &Y = x[1], &Z = x[2];
    return {A * X * X + B * Y * Y + C * Z * Z + 2 * (D * X * Y + E * X * Z + F * Y * Z) +
                2 * (G * X + H * Y + I * Z) + J,
            {2 * (A * X + D * Y + E * Z + G), 2 * (D * X + B * Y + F * Z + H),
             2 * (E * X + F * Y + C * Z + I)}};
  }
  if (s.kind == Kind::expression) {
    // The difference's own error is smooth and small; its noise, ε/step, is what further differences
    // of it see.
    using std::cbrt, std::sqrt;
    const T step = cbrt(T(sqrt(std::numeric_limits<T>::epsilon())));
    const ExpressionOracle<T> f(s.expression);
    const V<T> y = T(1 / T(s.unit)) * x;
    const V<T> gradient{f.partial(y, 0, step), f.partial(y, 1, step), f.partial(y, 2, step)};
    return {f(y), T(1 / T(s.unit)) * gradient};
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
  if (s.kind == Kind::sag || s.kind == Kind::zernike || s.kind == Kind::heights) {
    const V<T> e0 = from<T>(s.rotation.col(0)), e1 = from<T>(s.rotation.col(1));
    const V<T> e2 = from<T>(s.rotation.col(2));
    const auto h = height<T>(s, dot(y, e0), dot(y, e1));
    return {dot(y, e2) - h[0], e2 - h[1] * e0 - h[2] * e1};
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

  // Direction after a bounce, n against the light: the tangential part times η by Snell.
  static V<Real> turned(const solver::Optics& optics, int side, const V<Real>& in,
                        const V<Real>& n) {
    const Real c = dot(in, n);
    if (optics.kind == solver::Optics::Kind::mirror) return in - Real(2 * c) * n;
    const V<Real> across = Real(optics.eta(side)) * (in - c * n);
    return across - Real(sqrt(1 - dot(across, across))) * n;
  }
  // Fresnel by the sine and tangent formulas of the angles; metals by complex ones written out.
  static Real share(const solver::Optics& optics, int side, const Real& cosine) {
    if (optics.constant_share()) return 1;
    const Real i = acos(cosine), s = sin(i);
    if (optics.kind == solver::Optics::Kind::refract) {
      const Real t = asin(s * Real(optics.eta(side)));
      const Real sines = sin(i - t) / sin(i + t), tangents = tan(i - t) / tan(i + t);
      return 1 - (sines * sines + tangents * tangents) / 2;
    }
    // Born & Wolf §14.2: a and b of √(m² − sin² i) = a − ib.
    const Real n(optics.metal->real()), k(optics.metal->imag()), d = n * n - k * k - s * s;
    const Real root = sqrt(d * d + 4 * n * n * k * k), aa = (root + d) / 2, bb = (root - d) / 2;
    const Real a = sqrt(aa), t = s * s / cosine;
    const Real across =
        (aa + bb - 2 * a * cosine + cosine * cosine) / (aa + bb + 2 * a * cosine + cosine * cosine);
    const Real along = across * (aa + bb - 2 * a * t + t * t) / (aa + bb + 2 * a * t + t * t);
    return (across + along) / 2;
  }

  struct Arrival {
    std::array<Real, 2> q;
    V<Real> direction;
    Real share;
  };
  Arrival arrival(const V<Real>& x) const {
    V<Real> n = Real(scene_.side) * unit(implicit<Real>(scene_.shape, x).gradient);
    V<Real> at = x, out = omega(x);
    Real passed = share(scene_.optics, scene_.side, -dot(out, n));
    out = turned(scene_.optics, scene_.side, out, n);
    for (const ReferenceHop& hop : scene_.later) {
      Real distance(hop.distance);
      for (int i = 0; i < 8; ++i) {
        const auto g = implicit<Real>(hop.shape, at + distance * out);
        distance -= g.value / dot(g.gradient, out);
      }
      at = at + distance * out;
      n = Real(hop.side) * unit(implicit<Real>(hop.shape, at).gradient);
      passed *= share(hop.optics, hop.side, -dot(out, n));
      out = turned(hop.optics, hop.side, out, n);
    }
    const V<Real> y = at - from<Real>(scene_.receiver.origin);
    const Real tau = -dot(m_, y) / dot(m_, out);
    const V<Real> p = y + tau * out;
    return {{dot(u_, p), dot(v_, p)}, out, passed};
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
    Real constant = 1;
    for (const ReferenceHop& hop : scene_.later) {
      if (hop.optics.constant_share()) constant *= Real(hop.optics.share(1, 1.0).value);
    }
    return -scene_.side * constant * full_flux(x) * dot(omega(x), n) * arrival(x).share;
  }

  ReferenceField field(const V<Real>& x) const {
    const auto K = path_matrix(x);
    const V<Real> n = unit(K[2]);
    const auto e = tangents(n);
    // First derivatives of q along e1, e2, and their changes.
    const auto along = [&](const std::array<V<Real>, 3>& k, int j, int i) {
      return dot(k[j], e[i]);
    };
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
          second[j][i][k] = (along(K_hi, j, i) - along(K_lo, j, i)) / two_h - bend * dot(K[j], n);
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
    if (point_light())
      f.scale_of_grad_flux += static_cast<double>(3 * full_flux(x) / norm(x - source_));
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

LongImplicit reference_implicit(const ShapeSpec& spec, const std::array<long double, 3>& x) {
  const auto at = implicit<long double>(spec, x);
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
    const V<Real> change =
        unit(implicit<Real>(spec, hi).gradient) - unit(implicit<Real>(spec, lo).gradient);
    derivative.col(i) = rounded(Real(1 / (2 * kStep)) * change);
  }
  r.curvature = derivative * (Mat3::Identity() - r.normal * r.normal.transpose());
  return r;
}

ReferenceRay::ReferenceRay(const ShapeSpec& spec, const geometry::Ray& ray)
    : spec_(&spec), ray_(ray) {}

long double ReferenceRay::value(long double t) const {
  using T = long double;
  const auto here = implicit<T>(*spec_, from<T>(ray_.origin) + t * from<T>(ray_.direction));
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
