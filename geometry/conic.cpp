// Optician's conics: a quadric where there are no aspheric terms, a height field where there are.
#include <algorithm>
#include <cmath>

#include "geometry/quadric.h"
#include "geometry/root_finding.h"
#include "geometry/rotated_third.h"

namespace caustic::geometry {

namespace {

// The last radius of an ellipsoidal conic, where its slope is infinite, is left out by this share
// of its square.
constexpr double kRimShare = 1e-8;
// A point whose height gives w to within so much lies on the surface.
constexpr double kSurfaceShare = 1e-13;

// Height S(u) over u = r²: base conic plus Σ A_{4+2i} u^{i+2}, with derivatives in u.
//   S₀' = c/(2√w),  S₀'' = c κ/(4 w^{3/2}),  S₀''' = 3 c κ²/(8 w^{5/2});  κ = (1+k)c², w = 1 − κu.
struct Sag {
  double c, kappa;
  std::vector<double> terms;

  std::array<double, 4> at(double u) const {
    std::array<double, 4> s = base(std::min(u, last()));
    if (u > last()) {
      const double du = u - last();
      s[0] += du * (s[1] + 0.5 * du * (s[2] + du * s[3] / 3.0));
      s[1] += du * (s[2] + 0.5 * du * s[3]);
      s[2] += du * s[3];
    }
    return with_terms(u, s);
  }
  /// The same at height z. On the surface √w = 1 − κ(z − Σ …)/c: next to the last radius w is lost
  /// to rounding, but its root is not if it comes from the height.
  std::array<double, 4> at(double u, double z) const {
    double sum = 0.0;
    for (std::size_t i = terms.size(); i-- > 0;) sum = sum * u + terms[i];
    const double root = 1.0 - kappa / c * (z - u * u * sum);
    const bool on_surface =
        u < last() && root > 0.0 && std::abs(root * root - (1.0 - kappa * u)) <= kSurfaceShare;
    return on_surface ? with_terms(u, with_root(u, root)) : at(u);
  }
  /// Where the base conic has its last radius, less kRimShare. Beyond, its Taylor series of third
  /// order continues it: a wall, so that curves and rays find the rim from either side.
  double last() const { return kappa > 0.0 ? (1.0 - kRimShare) / kappa : kInfinity; }

  std::array<double, 4> base(double u) const { return with_root(u, std::sqrt(1.0 - kappa * u)); }
  std::array<double, 4> with_root(double u, double root) const {
    const double w = root * root;
    return {c * u / (1.0 + root), 0.5 * c / root, 0.25 * c * kappa / (w * root),
            0.375 * c * kappa * kappa / (w * w * root)};
  }
  std::array<double, 4> with_terms(double u, std::array<double, 4> s) const {
    double sum[4] = {};
    for (std::size_t i = terms.size(); i-- > 0;) {  // Horner for Σ A u^i and its derivatives
      for (int d = 3; d > 0; --d) sum[d] = sum[d] * u + d * sum[d - 1];
      sum[0] = sum[0] * u + terms[i];
    }
    // (u² p)' = 2u p + u² p', …
    s[0] += u * u * sum[0];
    s[1] += u * (2.0 * sum[0] + u * sum[1]);
    s[2] += 2.0 * sum[0] + u * (4.0 * sum[1] + u * sum[2]);
    s[3] += 6.0 * sum[1] + u * (6.0 * sum[2] + u * sum[3]);
    return s;
  }
  // Enclosure of the d-th derivative over 0 <= lo <= u <= hi: each power and each derivative of the
  // base conic is monotone.
  Interval range(int d, double lo, double hi) const {
    const Sag conic{c, kappa, {}};
    const double b0 = conic.at(lo)[d], b1 = conic.at(hi)[d];
    Interval sum{std::min(b0, b1), std::max(b0, b1)};
    double magnitude = std::max(std::abs(b0), std::abs(b1));
    const int first = std::max(0, d - 2);  // lower terms vanish
    double lo_power = std::pow(lo, first + 2 - d), hi_power = std::pow(hi, first + 2 - d);
    for (int i = first; i < static_cast<int>(terms.size()); ++i) {
      double factor = terms[i];
      for (int j = 0; j < d; ++j) factor *= i + 2 - j;
      const double v0 = factor * lo_power, v1 = factor * hi_power;
      sum.lo += std::min(v0, v1);
      sum.hi += std::max(v0, v1);
      magnitude += std::max(std::abs(v0), std::abs(v1));
      lo_power *= lo;
      hi_power *= hi;
    }
    const double slack = 1e-15 * magnitude * static_cast<double>(terms.size() + 4);
    return {sum.lo - slack, sum.hi + slack};
  }
};

// g = z − S(r²).
class Asphere final : public Surface {
 public:
  Asphere(const Point& vertex, const Mat3& axes, Sag sag)
      : o_(vertex), axes_(axes), sag_(std::move(sag)), last_(std::sqrt(sag_.last())) {}

  double value(const Point& x) const override {
    const Vec3 y = local(x);
    return y.z() - sag_.at(across(y))[0];
  }
  double value_gradient(const Point& x, Vec3& gradient) const override {
    const Vec3 y = local(x);
    const auto s = sag_.at(across(y));
    gradient = axes_ * Vec3(-2.0 * s[1] * y.x(), -2.0 * s[1] * y.y(), 1.0);
    return y.z() - s[0];
  }
  SurfaceDerivatives derivatives(const Point& x) const override {
    const Vec3 y = local(x);
    const auto s = sag_.at(across(y), y.z());
    Mat3 H = Mat3::Zero();
    const Vec2 flat = y.head<2>();
    H.topLeftCorner<2, 2>() = -4.0 * s[2] * flat * flat.transpose() - 2.0 * s[1] * Mat2::Identity();
    return {y.z() - sag_.at(across(y))[0],
            axes_ * Vec3(-2.0 * s[1] * y.x(), -2.0 * s[1] * y.y(), 1.0),
            axes_ * H * axes_.transpose()};
  }
  Vec3 third_derivative(const Point& x, const Vec3& u, const Vec3& v) const override {
    const Vec3 y = local(x);
    const auto s = sag_.at(across(y), y.z());
    const Vec2 flat = y.head<2>();
    const Vec2 a = (axes_.transpose() * u).head<2>(), b = (axes_.transpose() * v).head<2>();
    const double ya = flat.dot(a), yb = flat.dot(b);
    const Vec2 t = -8.0 * s[3] * ya * yb * flat - 4.0 * s[2] * (ya * b + yb * a + a.dot(b) * flat);
    return axes_ * Vec3(t.x(), t.y(), 0.0);
  }
  bool at_most_quadratic() const override { return false; }

  void crossings(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    const Along h(*this, ray);
    const std::size_t first = out.size();
    isolated_roots(Height{h}, t0 - h.shift, t1 - h.shift, out);
    h.unshift(out, first);
  }
  void stationary(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    const Along h(*this, ray);
    const std::size_t first = out.size();
    isolated_roots(Slope{h}, t0 - h.shift, t1 - h.shift, out);
    h.unshift(out, first);
  }

  bool convex(int) const override { return false; }
  SurfaceEnclosure enclose(const IntervalVec3& x) const override {
    const IntervalVec3 y = transposed(axes_, x - o_);
    const Interval u = sqr(y[0]) + sqr(y[1]);
    const Interval s0 = sag_.range(0, u.lo, u.hi), s1 = sag_.range(1, u.lo, u.hi);
    const Interval s2 = sag_.range(2, u.lo, u.hi);
    SurfaceEnclosure e{y[2] - s0, {-2.0 * s1 * y[0], -2.0 * s1 * y[1], 1.0}, {}};
    e.hessian = {-4.0 * s2 * sqr(y[0]) - 2.0 * s1,
                 -4.0 * s2 * y[0] * y[1],
                 0.0,
                 -4.0 * s2 * sqr(y[1]) - 2.0 * s1,
                 0.0,
                 0.0};
    return rotated(e, axes_);
  }
  IntervalSym333 enclose_third(const IntervalVec3& x) const override {
    const IntervalVec3 y = transposed(axes_, x - o_);
    const Interval u = sqr(y[0]) + sqr(y[1]);
    const Interval s2 = sag_.range(2, u.lo, u.hi), s3 = sag_.range(3, u.lo, u.hi);
    IntervalSym333 third;
    third.fill(Interval(0.0));
    third[packed_index(0, 0, 0)] = -8.0 * s3 * power(y[0], 3) - 12.0 * s2 * y[0];
    third[packed_index(0, 0, 1)] = -8.0 * s3 * sqr(y[0]) * y[1] - 4.0 * s2 * y[1];
    third[packed_index(0, 1, 1)] = -8.0 * s3 * y[0] * sqr(y[1]) - 4.0 * s2 * y[0];
    third[packed_index(1, 1, 1)] = -8.0 * s3 * power(y[1], 3) - 12.0 * s2 * y[1];
    return rotated(third, axes_);
  }
  Box bounds() const override {
    if (!std::isfinite(last_)) return {};
    const Interval z = sag_.range(0, 0.0, last_ * last_);
    return Box::around(o_, std::hypot(last_, std::max(std::abs(z.lo), std::abs(z.hi))));
  }
  std::vector<Bound> own_bounds() const override {
    if (!std::isfinite(last_)) return {};
    return {{Bound::Kind::cylinder, o_, axes_.col(2), last_, Bound::Origin::shape}};
  }
  std::vector<Chart> charts(const Extent& extent) const override {
    const Sag sag = sag_;
    if (!std::isfinite(last_)) {
      return sheet_charts(o_, axes_,
                          {[sag](double a, double b) { return sag.at(a * a + b * b)[0]; }})(extent);
    }
    // Square to disc: x = a√(1 − b²/2), y = b√(1 − a²/2); no further than the region reaches, since
    // near the last radius the surface is steep and large.
    double reach = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 pick((corner & 1) != 0, (corner & 2) != 0, (corner & 4) != 0);
      const Point x = extent.region.min + pick.cwiseProduct(extent.region.max - extent.region.min);
      reach = std::max(reach, std::sqrt(across(local(x))));
    }
    return {{[=, o = o_, axes = axes_, last = std::min(last_, reach)](double s, double t) {
      const double a = 2.0 * s - 1.0, b = 2.0 * t - 1.0;
      const double x = last * a * std::sqrt(1.0 - 0.5 * b * b);
      const double y = last * b * std::sqrt(1.0 - 0.5 * a * a);
      return Point(o + axes * Vec3(x, y, sag.at(x * x + y * y)[0]));
    }}};
  }

 private:
  Vec3 local(const Point& x) const { return axes_.transpose() * (x - o_); }
  static double across(const Vec3& y) { return y.x() * y.x() + y.y() * y.y(); }

  // h(τ) = z(τ) − S(u(τ)) along a ray; u is a parabola in τ, z a line. τ counts from the point
  // nearest to the vertex, so that u0 and u1 stay small for rays that come from afar.
  struct Along {
    double shift, z0, z1, u0, u1, u2;
    const Sag& sag;

    Along(const Asphere& s, const Ray& ray) : shift(ray.nearest(s.o_)), sag(s.sag_) {
      const Vec3 y = s.local(ray.at(shift)), d = s.axes_.transpose() * ray.direction;
      z0 = y.z();
      z1 = d.z();
      u0 = across(y);
      u1 = 2.0 * (y.x() * d.x() + y.y() * d.y());
      u2 = across(d);
    }
    double u(double t) const { return std::max(0.0, u0 + t * (u1 + t * u2)); }
    double du(double t) const { return u1 + 2.0 * u2 * t; }
    Interval u_range(double a, double b) const {
      const double ua = u(a), ub = u(b);
      Interval r{std::min(ua, ub), std::max(ua, ub)};
      if (du(a) < 0.0 && du(b) > 0.0) r.lo = std::max(0.0, u0 - 0.25 * u1 * u1 / u2);
      return {r.lo * (1.0 - 1e-14), r.hi * (1.0 + 1e-14)};
    }
    double value(double t) const { return z0 + z1 * t - sag.at(u(t))[0]; }
    double slope(double t) const { return z1 - sag.at(u(t))[1] * du(t); }
    double bend(double t) const {
      const auto s = sag.at(u(t));
      return -s[2] * du(t) * du(t) - 2.0 * s[1] * u2;
    }
    double twist(double t) const {
      const auto s = sag.at(u(t));
      return -du(t) * (s[3] * du(t) * du(t) + 6.0 * s[2] * u2);
    }
    Interval value_range(double a, double b) const {
      const Interval u_ab = u_range(a, b), s = sag.range(0, u_ab.lo, u_ab.hi);
      const double za = z0 + z1 * a, zb = z0 + z1 * b;
      const double slack = 1e-15 * (std::abs(z0) + std::abs(za) + std::abs(zb));
      return {std::min(za, zb) - s.hi - slack, std::max(za, zb) - s.lo + slack};
    }
    Interval slope_range(double a, double b) const {
      const Interval u_ab = u_range(a, b), s = sag.range(1, u_ab.lo, u_ab.hi);
      const Interval p = s * Interval(du(a), du(b));
      return {z1 - p.hi, z1 - p.lo};
    }
    Interval bend_range(double a, double b) const {
      const Interval u_ab = u_range(a, b), s1 = sag.range(1, u_ab.lo, u_ab.hi);
      const Interval s2 = sag.range(2, u_ab.lo, u_ab.hi);
      const double da = du(a) * du(a), db = du(b) * du(b);
      const bool turns = du(a) < 0.0 && du(b) > 0.0;
      const Interval p = s2 * Interval(turns ? 0.0 : std::min(da, db), std::max(da, db));
      return {-p.hi - 2.0 * u2 * s1.hi, -p.lo - 2.0 * u2 * s1.lo};
    }
    Interval twist_range(double a, double b) const {
      const Interval u_ab = u_range(a, b), s2 = sag.range(2, u_ab.lo, u_ab.hi);
      const Interval s3 = sag.range(3, u_ab.lo, u_ab.hi);
      const double da = du(a), db = du(b);
      const Interval p3 = s3 * Interval(da * da * da, db * db * db), p2 = s2 * Interval(da, db);
      return {-p3.hi - 6.0 * u2 * p2.hi, -p3.lo - 6.0 * u2 * p2.lo};
    }
    void unshift(RayParameters& out, std::size_t first) const {
      for (std::size_t i = first; i < out.size(); ++i) out[i] += shift;
    }
  };

  struct Height {
    const Along& h;
    double f(double t) const { return h.value(t); }
    double df(double t) const { return h.slope(t); }
    double ddf(double t) const { return h.bend(t); }
    Interval range_f(double a, double b) const { return h.value_range(a, b); }
    Interval range_df(double a, double b) const { return h.slope_range(a, b); }
    Interval range_ddf(double a, double b) const { return h.bend_range(a, b); }
  };
  struct Slope {
    const Along& h;
    double f(double t) const { return h.slope(t); }
    double df(double t) const { return h.bend(t); }
    double ddf(double t) const { return h.twist(t); }
    Interval range_f(double a, double b) const { return h.slope_range(a, b); }
    Interval range_df(double a, double b) const { return h.bend_range(a, b); }
    Interval range_ddf(double a, double b) const { return h.twist_range(a, b); }
  };

  Point o_;
  Mat3 axes_;
  Sag sag_;
  double last_;  // largest r, infinite if there is none
};

// g = z − (r² + (1+k) z²)/(2R), the vertex's sheet only.
SurfacePtr pure_conic(const Point& vertex, const Mat3& axes, double R, double k) {
  const double e = 1.0 + k;
  const QuadricForm form{vertex, axes, {-1.0 / R, -1.0 / R, -e / R}, Vec3::UnitZ(), 0.0};
  const Direction axis = axes.col(2);
  const ChartMaker sheet =
      sheet_charts(vertex, axes, {[=](double a, double b) {
                     const double c = 1.0 / R, u = a * a + b * b;
                     return c * u / (1.0 + std::sqrt(std::max(0.0, 1.0 - e * c * c * u)));
                   }});
  if (e == 0.0) return make_quadric_surface(form, sheet, {});

  const double half_length = R / e;  // signed height of the centre above the vertex
  const Direction towards = std::copysign(1.0, half_length) * axis;
  const Point center = vertex + half_length * axis;
  if (e < 0.0) {
    // The other sheet lies beyond the centre as seen from the vertex.
    const Bound this_sheet{Bound::Kind::half_space, center, towards, 0.0, Bound::Origin::shape};
    return make_quadric_surface(form, sheet, {}, {this_sheet});
  }
  const double last = std::abs(R) / std::sqrt(e), length = std::abs(half_length);
  const Bound near_half{Bound::Kind::half_space, center, towards, 0.0, Bound::Origin::shape};
  const ChartMaker cap = ellipsoid_charts(center, axes, {last, last, length});
  const Box box = Box::around(vertex, std::hypot(last, length));
  // A nearly parabolic conic is far larger than the scene: chart it as a height field there.
  const ChartMaker charts = [=](const Extent& extent) {
    const double reach = (extent.region.center() - vertex).norm() + extent.region.diagonal();
    return reach < last ? sheet(extent) : cap(extent);
  };
  return make_quadric_surface(form, charts, box, {near_half});
}

}  // namespace

SurfacePtr make_conic(const Point& vertex, const Direction& axis, double radius_of_curvature,
                      double conic_constant, const std::vector<double>& aspheric) {
  const Mat3 axes = axes_about(axis);
  if (std::all_of(aspheric.begin(), aspheric.end(), [](double a) { return a == 0.0; })) {
    return pure_conic(vertex, axes, radius_of_curvature, conic_constant);
  }
  const double c = 1.0 / radius_of_curvature, kappa = (1.0 + conic_constant) * c * c;
  return std::make_shared<Asphere>(vertex, axes, Sag{c, kappa, aspheric});
}

}  // namespace caustic::geometry
