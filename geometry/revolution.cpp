// Surfaces of revolution whose radius is a polynomial of the height (S20).
#include <algorithm>
#include <cassert>
#include <cmath>

#include "geometry/enclosed_polynomial.h"
#include "geometry/rotated_third.h"
#include "geometry/surface.h"

namespace caustic::geometry {

namespace {

// Charts go on beyond either end by this share of the height, so that the ends are cut like an
// aperture, where the radius keeps at least half of what it is at the end.
constexpr double kChartOverlap = 1.0 / 64.0;
// They begin this share of the height off an end where the radius is zero: an apex has no normal.
constexpr double kApexShare = 1e-6;
// A radius below this share of the mean one is zero.
constexpr double kZeroRadius = 1e-13;

// R over height z, R(z) = Σ c_i (z/h)^i.
struct Profile {
  LongPolynomial c;
  double h;

  double radius(double z) const { return c(z / h); }
  /// R, R', R'', R'''.
  std::array<double, 4> at(double z) const {
    const double w = z / h;
    double r[4] = {};
    for (int i = c.degree; i >= 0; --i) {
      for (int d = 3; d > 0; --d) r[d] = r[d] * w + d * r[d - 1];
      r[0] = r[0] * w + c.c[i];
    }
    return {r[0], r[1] / h, r[2] / (h * h), r[3] / (h * h * h)};
  }
  /// R, R', R'' over an interval.
  IntervalVec3 enclose(const Interval& z) const {
    const EnclosedPolynomial R(c);
    const Interval w = z / Interval(h);
    return {R.range_f(w.lo, w.hi), R.range_df(w.lo, w.hi) / Interval(h),
            R.range_ddf(w.lo, w.hi) / sqr(Interval(h))};
  }
  /// R''' over an interval.
  Interval third(const Interval& z) const {
    const Interval w = z / Interval(h);
    return EnclosedPolynomial(c.derivative()).range_ddf(w.lo, w.hi) / power(Interval(h), 3);
  }
  /// ∫R dz / h.
  double mean() const {
    double sum = 0.0;
    for (int i = c.degree; i >= 0; --i) sum += c.c[i] / (i + 1);
    return sum;
  }
};

// Heights in [0, h] where R is stationary, as shares of h.
std::vector<double> turns(const LongPolynomial& profile) {
  LongPolynomial slope = profile.derivative();
  while (slope.degree > 0 && slope.c[slope.degree] == 0.0) --slope.degree;
  std::vector<double> found;
  if (slope.degree > 0) isolated_roots(EnclosedPolynomial(slope), 0.0, 1.0, found);
  return found;
}

// g = (r² − R(z)²)/(2R̄), R̄ the mean radius: |∇g| = (R/R̄)√(1 + R'²) on the surface, smooth on the
// axis.
class Revolution final : public Surface {
 public:
  Revolution(const Point& origin, const Direction& axis, const Profile& profile)
      : o_(origin), axes_(axes_about(axis)), profile_(profile), scale_(1.0 / profile.mean()) {}

  double value(const Point& x) const override {
    const Vec3 y = local(x);
    return value_of(y.head<2>().norm(), profile_.radius(y.z()));
  }
  double value_gradient(const Point& x, Vec3& gradient) const override {
    const Vec3 y = local(x);
    const auto R = profile_.at(y.z());
    gradient = axes_ * Vec3(scale_ * y.x(), scale_ * y.y(), -scale_ * R[0] * R[1]);
    return value_of(y.head<2>().norm(), R[0]);
  }
  SurfaceDerivatives derivatives(const Point& x) const override {
    const Vec3 y = local(x);
    const auto R = profile_.at(y.z());
    const Vec3 bend(scale_, scale_, -scale_ * (R[1] * R[1] + R[0] * R[2]));
    return {value_of(y.head<2>().norm(), R[0]),
            axes_ * Vec3(scale_ * y.x(), scale_ * y.y(), -scale_ * R[0] * R[1]),
            axes_ * bend.asDiagonal() * axes_.transpose()};
  }
  Vec3 third_derivative(const Point& x, const Vec3& u, const Vec3& v) const override {
    const Direction axis = axes_.col(2);
    const auto R = profile_.at(axis.dot(x - o_));
    return -scale_ * (3.0 * R[1] * R[2] + R[0] * R[3]) * axis.dot(u) * axis.dot(v) * axis;
  }
  SurfaceEnclosure enclose(const IntervalVec3& x) const override {
    const IntervalVec3 y = transposed(axes_, x - o_);
    const auto [R, R1, R2] = profile_.enclose(y[2]);
    SurfaceEnclosure e{0.5 * scale_ * (sqr(y[0]) + sqr(y[1]) - sqr(R)),
                       {scale_ * y[0], scale_ * y[1], -scale_ * (R * R1)},
                       {}};
    e.hessian = {scale_, 0.0, 0.0, scale_, 0.0, -scale_ * (sqr(R1) + R * R2)};
    return rotated(e, axes_);
  }
  IntervalSym333 enclose_third(const IntervalVec3& x) const override {
    const Interval z = transposed(axes_, x - o_)[2];
    const auto [R, R1, R2] = profile_.enclose(z);
    IntervalSym333 third;
    third.fill(Interval(0.0));
    third[packed_index(2, 2, 2)] = -scale_ * (3.0 * R1 * R2 + R * profile_.third(z));
    return rotated(third, axes_);
  }
  bool at_most_quadratic() const override { return profile_.c.degree <= 1; }

  void crossings(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    const LocalRay r = about_middle(ray);
    const auto value = [&](double t) {
      const Vec3 y = r.at + t * r.direction;
      return value_of(y.head<2>().norm(), profile_.radius(y.z()));
    };
    append_roots(PolynomialWithValues(along(r), value), r.shift, t0, t1, out);
  }
  void stationary(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    const LocalRay r = about_middle(ray);
    append_roots(EnclosedPolynomial(along(r).derivative()), r.shift, t0, t1, out);
  }

  bool convex(int side) const override { return side > 0 && profile_.c.degree == 0; }
  Box bounds() const override {
    double largest = std::max(profile_.radius(0.0), profile_.radius(profile_.h));
    for (const double w : turns(profile_.c)) largest = std::max(largest, profile_.c(w));
    const Direction axis = axes_.col(2);
    const Vec3 reach = largest * (1.0 - axis.array().square()).max(0.0).sqrt();
    const Point top = o_ + profile_.h * axis;
    return {o_.cwiseMin(top) - reach, o_.cwiseMax(top) + reach};
  }
  std::vector<Bound> own_bounds() const override {
    const Direction axis = axes_.col(2);
    return {{Bound::Kind::half_space, o_, -axis, 0.0, Bound::Origin::shape},
            {Bound::Kind::half_space, o_ + profile_.h * axis, axis, 0.0, Bound::Origin::shape}};
  }
  std::vector<Chart> charts(const Extent&) const override {
    const double begin = chart_end(0.0, -1.0), end = chart_end(profile_.h, 1.0);
    return {{[=, o = o_, axes = axes_, profile = profile_](double s, double t) {
      const double angle = 2.0 * kPi * s, z = begin + t * (end - begin), r = profile.radius(z);
      return Point(o + axes * Vec3(r * std::cos(angle), r * std::sin(angle), z));
    }}};
  }

 private:
  Vec3 local(const Point& x) const { return axes_.transpose() * (x - o_); }
  // (r − R)(r + R) loses no digits near the surface.
  double value_of(double r, double R) const { return 0.5 * scale_ * (r - R) * (r + R); }

  double chart_end(double z, double outwards) const {
    const double radius = profile_.radius(z);
    if (radius <= kZeroRadius / scale_) return z - outwards * kApexShare * profile_.h;
    const double beyond = z + outwards * kChartOverlap * profile_.h;
    return profile_.radius(beyond) > 0.5 * radius ? beyond : z;
  }

  // τ counts from the point nearest to the middle of the axis.
  struct LocalRay {
    double shift;
    Vec3 at, direction;
  };
  LocalRay about_middle(const Ray& ray) const {
    const double shift = ray.nearest(o_ + 0.5 * profile_.h * axes_.col(2));
    return {shift, local(ray.at(shift)), axes_.transpose() * ray.direction};
  }
  // g as a polynomial of degree max(2, 2 deg R).
  LongPolynomial along(const LocalRay& r) const {
    LongPolynomial radius = profile_.c.about(r.at.z() / profile_.h);
    double power = 1.0;
    for (int k = 0; k <= radius.degree; ++k, power *= r.direction.z() / profile_.h) {
      radius.c[k] *= power;
    }
    LongPolynomial g = radius * radius;
    for (int k = 0; k <= g.degree; ++k) g.c[k] *= -0.5 * scale_;
    const Vec2 y = r.at.head<2>(), d = r.direction.head<2>();
    g.degree = std::max(2, g.degree);
    g.c[0] = value_of(y.norm(), radius.c[0]);
    g.c[1] += scale_ * y.dot(d);
    g.c[2] += 0.5 * scale_ * d.squaredNorm();
    return g;
  }

  Point o_;
  Mat3 axes_;
  Profile profile_;
  double scale_;
};

}  // namespace

RevolutionResult make_revolution(const Point& origin, const Direction& axis, double height,
                                 const std::vector<double>& coefficients) {
  assert(height > 0.0 && static_cast<int>(coefficients.size()) <= kMaxProfileDegree + 1);
  Profile profile{{}, height};
  for (int i = 0; i < static_cast<int>(coefficients.size()); ++i) {
    profile.c.c[i] = coefficients[i];
    if (coefficients[i] != 0.0) profile.c.degree = i;
  }
  // Between the ends the radius is least at an end or where it is stationary.
  const double zero = kZeroRadius * std::max(0.0, profile.mean());
  bool sound =
      profile.mean() > 0.0 && profile.radius(0.0) >= -zero && profile.radius(height) >= -zero;
  for (const double w : turns(profile.c)) {
    if (w > kApexShare && w < 1.0 - kApexShare) sound &= profile.c(w) > zero;
  }
  if (!sound) return {nullptr, "the radius must be > 0 at all heights between 0 and height"};
  return {std::make_shared<Revolution>(origin, axis, profile), {}};
}

}  // namespace caustic::geometry
