#include <cmath>

#include "geometry/ray_polynomial.h"
#include "geometry/surface.h"

namespace caustic::geometry {

namespace {

// The quartic, smooth everywhere: with y = x − c, y∥ = y − a(a·y) and w = |y|² + R² − r²,
//   g = (w² − 4R²|y∥|²)/(8R²r),   |∇g| = 1 ± r/R at the equators.
class Torus final : public Surface {
 public:
  Torus(const Point& center, const Direction& axis, double major, double minor)
      : c_(center),
        a_(axis),
        R_(major),
        r_(minor),
        scale_(0.125 / (major * major * minor)),
        P_(Mat3::Identity() - axis * axis.transpose()) {}

  double value(const Point& x) const override {
    Vec3 gradient;
    return value_gradient(x, gradient);
  }
  double value_gradient(const Point& x, Vec3& gradient) const override {
    const Vec3 y = x - c_, in_plane = P_ * y;
    const double w = excess(y), rho = in_plane.norm();
    gradient = scale_ * (4.0 * w * y - 8.0 * R_ * R_ * in_plane);
    // w − 2Rρ = z² + (ρ − R)² − r², without cancellation of the large terms.
    const double z = a_.dot(y), across = rho - R_;
    return scale_ * (z * z + (across - r_) * (across + r_)) * (w + 2.0 * R_ * rho);
  }
  SurfaceDerivatives derivatives(const Point& x) const override {
    SurfaceDerivatives d;
    d.g = value_gradient(x, d.gradient);
    const Vec3 y = x - c_;
    d.hessian = scale_ *
                (8.0 * y * y.transpose() + 4.0 * excess(y) * Mat3::Identity() - 8.0 * R_ * R_ * P_);
    return d;
  }
  Vec3 third_derivative(const Point& x, const Vec3& u, const Vec3& v) const override {
    const Vec3 y = x - c_;
    return 8.0 * scale_ * (y.dot(u) * v + y.dot(v) * u + u.dot(v) * y);
  }
  SurfaceEnclosure enclose(const IntervalVec3& x) const override {
    const IntervalVec3 y = x - c_, in_plane = P_ * y;
    const Interval w = squared_norm(y) + Interval(R_ - r_) * (R_ + r_), RR = sqr(R_);
    const Interval rho = sqrt(squared_norm(in_plane));
    SurfaceEnclosure e;
    e.g = scale_ * (sqr(dot(a_, y)) + sqr(rho - R_) - sqr(r_)) * (w + 2.0 * R_ * rho);
    for (int i = 0; i < 3; ++i) e.gradient[i] = scale_ * (4.0 * w * y[i] - 8.0 * RR * in_plane[i]);
    for (int k = 0; k < 6; ++k) {
      const auto [i, j] = kPackedIndices[k];
      const Interval yy = i == j ? sqr(y[i]) + 0.5 * w : y[i] * y[j];
      e.hessian[k] = scale_ * (8.0 * (yy - RR * P_(i, j)));
    }
    return e;
  }
  IntervalSym333 enclose_third(const IntervalVec3& x) const override {
    const IntervalVec3 y = x - c_;
    IntervalSym333 third;
    for (int a = 0; a < 3; ++a) {
      for (int b = a; b < 3; ++b) {
        for (int c = b; c < 3; ++c) {
          Interval sum(0.0);
          if (a == b) sum += y[static_cast<std::size_t>(c)];
          if (a == c) sum += y[static_cast<std::size_t>(b)];
          if (b == c) sum += y[static_cast<std::size_t>(a)];
          third[packed_index(a, b, c)] = (8.0 * scale_) * sum;
        }
      }
    }
    return third;
  }
  bool at_most_quadratic() const override { return false; }

  void crossings(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    find(ray, Along::crossings, t0, t1, out);
  }
  void stationary(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    find(ray, Along::stationary, t0, t1, out);
  }

  bool convex(int) const override { return false; }
  Box bounds() const override { return Box::around(c_, R_ + r_); }
  std::vector<Chart> charts(const Extent&) const override {
    const Frame frame(a_);
    return {{[=, c = c_, a = a_, R = R_, r = r_](double s, double t) {
      const double around = 2.0 * kPi * s, tube = 2.0 * kPi * t;
      const Direction out = std::cos(around) * frame.e1 + std::sin(around) * frame.e2;
      return Point(c + (R + r * std::cos(tube)) * out + r * std::sin(tube) * a);
    }}};
  }

 private:
  double excess(const Vec3& y) const { return y.squaredNorm() + (R_ - r_) * (R_ + r_); }

  void find(const Ray& ray, Along what, double t0, double t1, RayParameters& out) const {
    roots_along([&](const Ray& r) { return along(r); }, ray, c_, what, t0, t1, out);
  }
  Polynomial along(const Ray& ray) const {
    const Vec3 y = ray.origin - c_, d = ray.direction;
    const double dd = d.squaredNorm(), yd = y.dot(d), w = excess(y);
    const double pd = d.dot(P_ * d), py = y.dot(P_ * d), yy = y.dot(P_ * y), f = 4.0 * R_ * R_;
    return {{scale_ * (w * w - f * yy), scale_ * (4.0 * w * yd - 2.0 * f * py),
             scale_ * (4.0 * yd * yd + 2.0 * w * dd - f * pd), scale_ * 4.0 * dd * yd,
             scale_ * dd * dd},
            4};
  }

  Point c_;
  Direction a_;
  double R_, r_, scale_;
  Mat3 P_;
};

}  // namespace

SurfacePtr make_torus(const Point& center, const Direction& axis, double major_radius,
                      double minor_radius) {
  return std::make_shared<Torus>(center, axis, major_radius, minor_radius);
}

}  // namespace caustic::geometry
