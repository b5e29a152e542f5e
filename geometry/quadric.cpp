#include "geometry/quadric.h"

#include <cmath>

#include "geometry/cube_sphere.h"
#include "geometry/ray_polynomial.h"

namespace caustic::geometry {

namespace {

class Quadric final : public Surface {
 public:
  Quadric(const QuadricForm& form, ChartMaker charts, const Box& box, std::vector<Bound> bounds)
      : o_(form.origin),
        A_(form.axes * form.lambda.asDiagonal() * form.axes.transpose()),
        b_(form.axes * form.linear),
        k_(form.constant),
        convex_{(form.lambda.array() <= 0.0).all(), (form.lambda.array() >= 0.0).all()},
        charts_(std::move(charts)),
        box_(box),
        bounds_(std::move(bounds)) {}

  double value(const Point& x) const override {
    const Vec3 y = x - o_;
    return y.dot(0.5 * (A_ * y) + b_) + k_;
  }
  double value_gradient(const Point& x, Vec3& gradient) const override {
    const Vec3 y = x - o_;
    const Vec3 Ay = A_ * y;
    gradient = Ay + b_;
    return y.dot(0.5 * Ay + b_) + k_;
  }
  SurfaceDerivatives derivatives(const Point& x) const override {
    SurfaceDerivatives d;
    d.g = value_gradient(x, d.gradient);
    d.hessian = A_;
    return d;
  }
  Vec3 third_derivative(const Point&, const Vec3&, const Vec3&) const override {
    return Vec3::Zero();
  }
  SurfaceEnclosure enclose(const IntervalVec3& x) const override {
    const IntervalVec3 y = x - o_, Ay = A_ * y;
    const Interval squares =
        A_(0, 0) * sqr(y[0]) + A_(1, 1) * sqr(y[1]) + A_(2, 2) * sqr(y[2]);
    const Interval products =
        A_(0, 1) * (y[0] * y[1]) + A_(0, 2) * (y[0] * y[2]) + A_(1, 2) * (y[1] * y[2]);
    return {0.5 * squares + products + dot(b_, y) + k_,
            {Ay[0] + b_[0], Ay[1] + b_[1], Ay[2] + b_[2]},
            packed(A_)};
  }
  bool at_most_quadratic() const override { return true; }

  void crossings(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    find(ray, Along::crossings, t0, t1, out);
  }
  void stationary(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    find(ray, Along::stationary, t0, t1, out);
  }

  bool convex(int side) const override { return convex_[side > 0 ? 1 : 0]; }
  Box bounds() const override { return box_; }
  std::vector<Bound> own_bounds() const override { return bounds_; }
  std::vector<Chart> charts(const Extent& extent) const override { return charts_(extent); }

 private:
  void find(const Ray& ray, Along what, double t0, double t1, RayParameters& out) const {
    roots_along([&](const Ray& r) { return along(r); }, ray, o_, what, t0, t1, out);
  }
  Polynomial along(const Ray& ray) const {
    Vec3 gradient;
    const double g = value_gradient(ray.origin, gradient);
    return {{g, gradient.dot(ray.direction), 0.5 * ray.direction.dot(A_ * ray.direction)}, 2};
  }

  Point o_;
  Mat3 A_;
  Vec3 b_;
  double k_;
  std::array<bool, 2> convex_;  // {−g <= 0}, {g <= 0}: sublevel sets of a convex function
  ChartMaker charts_;
  Box box_;
  std::vector<Bound> bounds_;
};

}  // namespace

SurfacePtr make_quadric_surface(const QuadricForm& form, ChartMaker charts, const Box& box,
                                std::vector<Bound> bounds) {
  return std::make_shared<Quadric>(form, std::move(charts), box, std::move(bounds));
}

ChartMaker ellipsoid_charts(const Point& center, const Mat3& axes, const Vec3& semi_axes) {
  return [=](const Extent&) {
    std::vector<Chart> charts;
    const Mat3 stretch = axes * semi_axes.asDiagonal();
    for (int face = 0; face < 6; ++face) {
      charts.push_back({[=](double s, double t) {
        return Point(center + stretch * cube_sphere(face, s, t));
      }});
    }
    return charts;
  };
}

ChartMaker tube_charts(const Point& origin, const Mat3& axes, double a, double b, double c0,
                       double c2) {
  return [=](const Extent& extent) -> std::vector<Chart> {
    const GradedRange range(extent, origin, axes.col(2));
    const auto at = [=](double angle, double z) {
      const double rho = std::sqrt(c0 + c2 * z * z);
      return Point(origin + axes * Vec3(a * rho * std::cos(angle), b * rho * std::sin(angle), z));
    };
    if (c0 > 0.0) {
      return {{[=](double s, double t) { return at(2.0 * kPi * s, range(t)); }}};
    }
    // Each nappe from just off the apex, where the cone has no normal.
    std::vector<Chart> nappes;
    for (const double end : {range(0.0), range(1.0)}) {
      const double reach = std::asinh(end / extent.scale);
      nappes.push_back({[=](double s, double t) {
        const double w = 1e-6 + (1.0 - 1e-6) * t;
        return at(2.0 * kPi * s, extent.scale * std::sinh(reach * w));
      }});
    }
    return nappes;
  };
}

ChartMaker sheet_charts(const Point& origin, const Mat3& axes, std::vector<Height> heights) {
  return [=](const Extent& extent) {
    const GradedRange y0(extent, origin, axes.col(0)), y1(extent, origin, axes.col(1));
    std::vector<Chart> charts;
    for (const Height& height : heights) {
      charts.push_back({[=](double s, double t) {
        const double a = y0(s), b = y1(t);
        return Point(origin + axes * Vec3(a, b, height(a, b)));
      }});
    }
    return charts;
  };
}

SurfacePtr make_ellipsoid(const Point& center, const Vec3& semi_axes, const Mat3& rotation) {
  const double scale = semi_axes.minCoeff();
  const QuadricForm form{center, rotation, scale * semi_axes.cwiseAbs2().cwiseInverse(), Vec3::Zero(),
                         -0.5 * scale};
  const Vec3 reach = (rotation * semi_axes.asDiagonal()).rowwise().norm();
  return make_quadric_surface(form, ellipsoid_charts(center, rotation, semi_axes),
                              {center - reach, center + reach});
}

SurfacePtr make_cylinder(const Point& point, const Direction& axis, double radius) {
  const Mat3 axes = axes_about(axis);
  const QuadricForm form{point, axes, {1.0 / radius, 1.0 / radius, 0.0}, Vec3::Zero(),
                         -0.5 * radius};
  return make_quadric_surface(form, tube_charts(point, axes, radius, radius, 1.0, 0.0), {});
}

SurfacePtr make_cone(const Point& apex, const Direction& axis, double half_angle) {
  const Mat3 axes = axes_about(axis);
  const double slope = std::tan(half_angle);
  const QuadricForm form{apex, axes, {1.0, 1.0, -slope * slope}, Vec3::Zero(), 0.0};
  return make_quadric_surface(form, tube_charts(apex, axes, slope, slope, 0.0, 1.0), {});
}

}  // namespace caustic::geometry
