// The rectangle on which light is measured, with its own axes. It blocks nothing.
#pragma once

#include <cmath>

#include "geometry/linear.h"

namespace caustic::geometry {

/// Right-handed frame (u, v, m) at the centre of a rectangle. q = (u·(p − o), v·(p − o)).
struct ReceiverFrame {
  Point origin;
  Direction u, v, m;
  Vec2 half;  ///< half the size along u and v, metres

  /// `u_axis` is normalised and `v_axis` made perpendicular to it; they must not be parallel.
  static ReceiverFrame make(const Point& origin, const Vec3& u_axis, const Vec3& v_axis,
                            const Vec2& size) {
    const Direction u = u_axis.normalized();
    const Direction v = (v_axis - u * u.dot(v_axis)).normalized();
    return {origin, u, v, u.cross(v), 0.5 * size};
  }

  Point point(const Vec2& q) const { return origin + q.x() * u + q.y() * v; }
  double width() const { return 2.0 * half.maxCoeff(); }
  bool contains(const Vec2& q) const {
    return std::abs(q.x()) <= half.x() && std::abs(q.y()) <= half.y();
  }
};

}  // namespace caustic::geometry
