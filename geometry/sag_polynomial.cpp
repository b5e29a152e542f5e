// Height fields that are polynomials in x and y, Zernike's among them (S21).
#include <algorithm>
#include <cassert>
#include <cmath>

#include "geometry/quadric.h"
#include "geometry/sag.h"

namespace caustic::geometry {

void XyPolynomial::add(int i, int j, double c) {
  assert(i >= 0 && j >= 0 && i + j <= kMaxDegree);
  if (c == 0.0) return;
  if (i + j > degree_) {
    XyPolynomial larger(unit_);
    larger.degree_ = i + j;
    larger.c_.assign((i + j + 1) * (i + j + 2) / 2, 0.0);
    for (int k = 0; k <= degree_; ++k) {
      for (int l = 0; k + l <= degree_; ++l) larger.c_[larger.index(k, l)] = c_[index(k, l)];
    }
    *this = std::move(larger);
  }
  c_[index(i, j)] += c;
}

double XyPolynomial::coefficient(int i, int j) const {
  return i + j <= degree_ ? c_[index(i, j)] : 0.0;
}

// Horner in y within Horner in x, both with derivatives: d[a][b] = ∂^(a+b) f/∂x^a∂y^b / (a! b!).
template <int kOrder>
void XyPolynomial::derivatives(double x, double y, double (&d)[kOrder + 1][kOrder + 1]) const {
  for (auto& row : d) std::fill(std::begin(row), std::end(row), 0.0);
  for (int i = degree_; i >= 0; --i) {
    double p[kOrder + 1] = {};
    for (int j = degree_ - i; j >= 0; --j) {
      for (int b = kOrder; b > 0; --b) p[b] = p[b] * y + p[b - 1];
      p[0] = p[0] * y + c_[index(i, j)];
    }
    for (int b = 0; b <= kOrder; ++b) {
      for (int a = kOrder - b; a > 0; --a) d[a][b] = d[a][b] * x + d[a - 1][b];
      d[0][b] = d[0][b] * x + p[b];
    }
  }
}

double XyPolynomial::operator()(double x, double y) const {
  double d[1][1];
  derivatives<0>(x / unit_, y / unit_, d);
  return d[0][0];
}

double XyPolynomial::slope(double x, double y, Vec2& slope) const {
  double d[2][2];
  derivatives<1>(x / unit_, y / unit_, d);
  slope = Vec2(d[1][0], d[0][1]) / unit_;
  return d[0][0];
}

HeightJet XyPolynomial::jet(double x, double y) const {
  double d[4][4];
  derivatives<3>(x / unit_, y / unit_, d);
  const double k1 = 1.0 / unit_, k2 = k1 * k1, k3 = k1 * k2;
  return {d[0][0],
          {k1 * d[1][0], k1 * d[0][1]},
          {2.0 * k2 * d[2][0], k2 * d[1][1], 2.0 * k2 * d[0][2]},
          {6.0 * k3 * d[3][0], 2.0 * k3 * d[2][1], 2.0 * k3 * d[1][2], 6.0 * k3 * d[0][3]}};
}

// The Taylor series about the middle of the box, by synthetic division in y, then in x. Its
// coefficients carry rounding errors of n ε Σ |c| |x|^i |y|^j times a small number.
template <std::size_t kCount>
std::array<Interval, kCount> XyPolynomial::ranges_of(const int (&orders)[kCount][2],
                                                     const Interval& x, const Interval& y) const {
  const Interval xs = x / Interval(unit_), ys = y / Interval(unit_);
  const double mx = xs.middle(), my = ys.middle();
  const double hx = std::max(xs.hi - mx, mx - xs.lo), hy = std::max(ys.hi - my, my - ys.lo);
  const int n = degree_;
  double t[kMaxDegree + 1][kMaxDegree + 1] = {};
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) t[i][j] = c_[index(i, j)];
    for (int first = 0; first < n - i; ++first) {
      for (int j = n - i - 1; j >= first; --j) t[i][j] += my * t[i][j + 1];
    }
  }
  for (int first = 0; first < n; ++first) {
    for (int i = n - 1; i >= first; --i) {
      for (int j = 0; j <= n; ++j) t[i][j] += mx * t[i + 1][j];
    }
  }
  auto r = taylor_ranges(
      orders, n, n, [&](int i, int j) { return t[i][j]; }, hx, hy);
  const auto size = taylor_ranges(
      orders, n, n, [&](int i, int j) { return std::abs(coefficient(i, j)); }, std::abs(mx) + hx,
      std::abs(my) + hy);
  for (std::size_t k = 0; k < kCount; ++k) {
    const double slack = 8.0 * (n + 2) * kEpsilon * size[k].hi;
    r[k] += Interval(-slack, slack);
    for (int i = 0; i < orders[k][0] + orders[k][1]; ++i) r[k] = r[k] / Interval(unit_);
  }
  return r;
}

HeightRanges XyPolynomial::ranges(const Interval& x, const Interval& y) const {
  return ranges_of(kOrdersOfRanges, x, y);
}
ThirdRanges XyPolynomial::third_ranges(const Interval& x, const Interval& y) const {
  return ranges_of(kOrdersOfThirds, x, y);
}

LongPolynomial XyPolynomial::along(const Vec2& at, const Vec2& direction) const {
  const Vec2 p = at / unit_, q = direction / unit_;
  // sum ← sum · (p + q t) + constant
  const auto horner = [](LongPolynomial& sum, int degree, double p0, double q0) {
    for (int k = degree; k > 0; --k) sum.c[k] = p0 * sum.c[k] + q0 * sum.c[k - 1];
    sum.c[0] *= p0;
  };
  LongPolynomial f;
  for (int i = degree_; i >= 0; --i) {
    LongPolynomial row;
    for (int j = degree_ - i; j >= 0; --j) {
      horner(row, degree_ - i - j, p.y(), q.y());
      row.c[0] += c_[index(i, j)];
    }
    horner(f, degree_ - i, p.x(), q.x());
    for (int k = 0; k <= degree_ - i; ++k) f.c[k] += row.c[k];
  }
  f.degree = degree_;
  return f;
}

XyPolynomial zernike(const std::vector<std::pair<int, double>>& coefficients, double norm_radius) {
  const auto factorial = [](int n) { return std::tgamma(n + 1.0); };
  const auto binomial = [&](int n, int k) {
    return std::round(factorial(n) / (factorial(k) * factorial(n - k)));
  };
  XyPolynomial sum(norm_radius);
  for (const auto& [index, coefficient] : coefficients) {
    assert(index >= 0 && index <= kMaxZernikeIndex);
    const int n = static_cast<int>(std::ceil(0.5 * (-3.0 + std::sqrt(9.0 + 8.0 * index))));
    const int m = 2 * index - n * (n + 2), order = std::abs(m);
    const double scale = coefficient * std::sqrt((m == 0 ? 1.0 : 2.0) * (n + 1));
    // r^|m| cos |m|θ and sin |m|θ are the parts of (x + iy)^|m|, the rest a polynomial in r².
    for (int k = 0; 2 * k <= n - order; ++k) {
      const int p = (n - order) / 2 - k;
      const double radial =
          (k % 2 == 0 ? 1.0 : -1.0) *
          std::round(factorial(n - k) / (factorial(k) * factorial(p + order) * factorial(p)));
      for (int l = m < 0 ? 1 : 0; l <= order; l += 2) {
        const double angular = (l / 2 % 2 == 0 ? 1.0 : -1.0) * binomial(order, l);
        for (int q = 0; q <= p; ++q) {
          sum.add(order - l + 2 * (p - q), l + 2 * q, scale * radial * angular * binomial(p, q));
        }
      }
    }
  }
  return sum;
}

namespace {

class SagPolynomial final : public SagSurface {
 public:
  SagPolynomial(const Point& origin, const Mat3& axes, XyPolynomial f)
      : SagSurface(origin, axes), f_(std::move(f)) {}

  bool at_most_quadratic() const override { return f_.degree() <= 2; }

  void crossings(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    const LocalRay r = about_origin(ray);
    const auto value = [&](double t) { return r.z(t) - f_(r.x(t), r.y(t)); };
    append_roots(PolynomialWithValues(along(r), value), r.shift, t0, t1, out);
  }
  void stationary(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    const LocalRay r = about_origin(ray);
    append_roots(EnclosedPolynomial(along(r).derivative()), r.shift, t0, t1, out);
  }

  /// { z ≤ f } where f is a concave parabola, { z ≥ f } where it is a convex one.
  bool convex(int side) const override {
    if (f_.degree() > 2) return false;
    const double xx = -2.0 * side * f_.coefficient(2, 0), yy = -2.0 * side * f_.coefficient(0, 2);
    const double xy = f_.coefficient(1, 1);
    return xx >= 0.0 && yy >= 0.0 && xx * yy >= xy * xy;
  }
  Box bounds() const override { return {}; }
  std::vector<Chart> charts(const Extent& extent) const override {
    return sheet_charts(o_, axes_, {[f = f_](double x, double y) { return f(x, y); }})(extent);
  }

 private:
  double height(double x, double y) const override { return f_(x, y); }
  double height_slope(double x, double y, Vec2& slope) const override {
    return f_.slope(x, y, slope);
  }
  HeightJet height_jet(double x, double y) const override { return f_.jet(x, y); }
  HeightRanges height_ranges(const Interval& x, const Interval& y) const override {
    return f_.ranges(x, y);
  }
  ThirdRanges height_third_ranges(const Interval& x, const Interval& y) const override {
    return f_.third_ranges(x, y);
  }

  // τ counts from the point nearest to the origin.
  struct LocalRay {
    double shift;
    Vec3 at, direction;
    double x(double t) const { return at.x() + t * direction.x(); }
    double y(double t) const { return at.y() + t * direction.y(); }
    double z(double t) const { return at.z() + t * direction.z(); }
  };
  LocalRay about_origin(const Ray& ray) const {
    const double shift = ray.nearest(o_);
    return {shift, local(ray.at(shift)), axes_.transpose() * ray.direction};
  }
  LongPolynomial along(const LocalRay& r) const {
    LongPolynomial g = f_.along(r.at.head<2>(), r.direction.head<2>());
    for (int k = 0; k <= g.degree; ++k) g.c[k] = -g.c[k];
    g.degree = std::max(1, g.degree);
    g.c[0] += r.at.z();
    g.c[1] += r.direction.z();
    return g;
  }

  XyPolynomial f_;
};

}  // namespace

SurfacePtr make_sag(const Point& origin, const Mat3& axes, const XyPolynomial& height) {
  return std::make_shared<SagPolynomial>(origin, axes, height);
}

}  // namespace caustic::geometry
