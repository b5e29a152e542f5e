// Names for vectors, so that a signature tells a point from a direction from a normal.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>
#include <utility>

namespace caustic::geometry {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat2 = Eigen::Matrix2d;
using Mat3 = Eigen::Matrix3d;

using Point = Vec3;      ///< a place, world coordinates, metres
using Direction = Vec3;  ///< a unit vector unless said otherwise
using Normal = Vec3;     ///< a unit vector across a surface

constexpr double kPi = 3.14159265358979323846;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// The half line (or line) x(τ) = origin + τ·direction. The direction need not be a unit vector.
/// Twice the signed area of the triangle 0, a, b: positive if b is to the left of a.
inline double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

struct Ray {
  Point origin;
  Vec3 direction;

  Point at(double t) const { return origin + t * direction; }
  /// τ of the point nearest to x.
  double nearest(const Point& x) const {
    return (x - origin).dot(direction) / direction.squaredNorm();
  }
};

/// Two unit vectors that complete the unit vector n to a right-handed frame (e1, e2, n).
/// Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6 (2017).
struct Frame {
  Direction e1, e2;

  explicit Frame(const Direction& n) {
    const double sign = std::copysign(1.0, n.z());
    const double a = -1.0 / (sign + n.z());
    const double b = n.x() * n.y() * a;
    e1 = {1.0 + sign * n.x() * n.x() * a, sign * b, -sign * n.x()};
    e2 = {b, sign + n.y() * n.y() * a, -n.y()};
  }
};

/// Columns e1, e2, axis: a right-handed frame about a unit vector.
inline Mat3 axes_about(const Direction& axis) {
  const Frame frame(axis);
  Mat3 axes;
  axes << frame.e1, frame.e2, axis;
  return axes;
}

/// Axis-aligned box; empty when min > max somewhere.
struct Box {
  Point min = Point::Constant(-kInfinity);
  Point max = Point::Constant(kInfinity);

  bool empty() const { return (min.array() > max.array()).any(); }
  bool bounded() const { return min.allFinite() && max.allFinite(); }
  bool contains(const Point& x) const {
    return (x.array() >= min.array()).all() && (x.array() <= max.array()).all();
  }
  Point center() const { return 0.5 * (min + max); }
  double diagonal() const { return (max - min).norm(); }
  Box intersected(const Box& other) const {
    return {min.cwiseMax(other.min), max.cwiseMin(other.max)};
  }
  /// Where the segment ray(0…1) is in the box widened by `margin`: from the first parameter to the
  /// second, nowhere if that is less.
  std::pair<double, double> span_of(const Ray& ray, double margin) const {
    double enter = 0.0, leave = 1.0;
    for (int i = 0; i < 3; ++i) {
      const double inverse = 1.0 / ray.direction[i];
      double near = (min[i] - margin - ray.origin[i]) * inverse;
      double far = (max[i] + margin - ray.origin[i]) * inverse;
      if (inverse < 0.0) std::swap(near, far);
      // A ray in the box's own plane gives 0·∞; the comparisons below then keep the bounds.
      if (near > enter) enter = near;
      if (far < leave) leave = far;
    }
    return {enter, leave};
  }
  /// False only if the segment ray(0…1) misses the box widened by `margin`.
  bool may_meet(const Ray& ray, double margin) const {
    const auto [enter, leave] = span_of(ray, margin);
    return enter <= leave;
  }
  static Box around(const Point& center, double radius) {
    return {center.array() - radius, center.array() + radius};
  }
};

}  // namespace caustic::geometry
