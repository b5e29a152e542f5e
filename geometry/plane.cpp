#include "geometry/surface.h"

namespace caustic::geometry {

namespace {

// g = n·(x − p).
class Plane final : public Surface {
 public:
  Plane(const Point& point, const Normal& normal) : p_(point), n_(normal) {}

  double value(const Point& x) const override { return n_.dot(x - p_); }
  double value_gradient(const Point& x, Vec3& gradient) const override {
    gradient = n_;
    return value(x);
  }
  SurfaceDerivatives derivatives(const Point& x) const override {
    return {value(x), n_, Mat3::Zero()};
  }
  Vec3 third_derivative(const Point&, const Vec3&, const Vec3&) const override {
    return Vec3::Zero();
  }
  SurfaceEnclosure enclose(const IntervalVec3& x) const override {
    return {dot(n_, x - p_), intervals(n_), packed(Mat3::Zero())};
  }
  bool flat() const override { return true; }
  bool at_most_quadratic() const override { return true; }

  void crossings(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    const double slope = n_.dot(ray.direction);
    if (slope == 0.0) return;
    const double t = -value(ray.origin) / slope;
    if (t >= t0 && t <= t1) out.push_back(t);
  }
  void stationary(const Ray&, double, double, RayParameters&) const override {}

  bool convex(int) const override { return true; }
  Box bounds() const override { return {}; }
  std::vector<Chart> charts(const Extent& extent) const override {
    // The origin is the foot of the focus, where the grading is finest.
    const Point foot = extent.focus - n_ * value(extent.focus);
    const Frame frame(n_);
    const GradedRange s(extent, foot, frame.e1), t(extent, foot, frame.e2);
    return {{[foot, frame, s, t](double a, double b) {
      return Point(foot + s(a) * frame.e1 + t(b) * frame.e2);
    }}};
  }

 private:
  Point p_;
  Normal n_;
};

}  // namespace

SurfacePtr make_plane(const Point& point, const Normal& normal) {
  return std::make_shared<Plane>(point, normal);
}

}  // namespace caustic::geometry
