#include "geometry/cube_sphere.h"
#include "geometry/ray_polynomial.h"
#include "geometry/surface.h"

namespace caustic::geometry {

namespace {

// g = (|x − c|² − r²)/(2r).
class Sphere final : public Surface {
 public:
  Sphere(const Point& center, double radius) : c_(center), r_(radius) {}

  double value(const Point& x) const override {
    // (|y| − r)(|y| + r) loses no digits near the surface.
    const double length = (x - c_).norm();
    return 0.5 * (length - r_) * (length + r_) / r_;
  }
  double value_gradient(const Point& x, Vec3& gradient) const override {
    gradient = (x - c_) / r_;
    return value(x);
  }
  SurfaceDerivatives derivatives(const Point& x) const override {
    return {value(x), (x - c_) / r_, Mat3::Identity() / r_};
  }
  Vec3 third_derivative(const Point&, const Vec3&, const Vec3&) const override {
    return Vec3::Zero();
  }
  SurfaceEnclosure enclose(const IntervalVec3& x) const override {
    const IntervalVec3 y = x - c_;
    return {(squared_norm(y) - sqr(r_)) / (2.0 * r_),
            {y[0] / r_, y[1] / r_, y[2] / r_},
            packed(Mat3::Identity() / r_)};
  }
  bool at_most_quadratic() const override { return true; }

  void crossings(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    find(ray, Along::crossings, t0, t1, out);
  }
  void stationary(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    find(ray, Along::stationary, t0, t1, out);
  }

  bool convex(int side) const override { return side > 0; }
  Box bounds() const override { return Box::around(c_, r_); }
  std::vector<Chart> charts(const Extent&) const override {
    std::vector<Chart> charts;
    for (int face = 0; face < 6; ++face) {
      charts.push_back({[c = c_, r = r_, face](double s, double t) {
        return Point(c + r * cube_sphere(face, s, t));
      }});
    }
    return charts;
  }

 private:
  void find(const Ray& ray, Along what, double t0, double t1, RayParameters& out) const {
    roots_along([&](const Ray& r) { return along(r); }, ray, c_, what, t0, t1, out);
  }
  Polynomial along(const Ray& ray) const {
    const Vec3 y = ray.origin - c_;
    return {{value(ray.origin), y.dot(ray.direction) / r_, 0.5 * ray.direction.squaredNorm() / r_},
            2};
  }

  Point c_;
  double r_;
};

}  // namespace

SurfacePtr make_sphere(const Point& center, double radius) {
  return std::make_shared<Sphere>(center, radius);
}

}  // namespace caustic::geometry
