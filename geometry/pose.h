// A rigid motion x_world = R x + t: rotation about the world origin first, then translation.
#pragma once

#include "geometry/linear.h"

namespace caustic::geometry {

struct Pose {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();

  Point point(const Point& x) const { return rotation * x + translation; }
  Vec3 direction(const Vec3& d) const { return rotation * d; }

  /// Rotation by `radians` about `axis` (a unit vector) through the world origin, then translation.
  static Pose make(const Direction& axis, double radians, const Vec3& translation) {
    return {Eigen::AngleAxisd(radians, axis).toRotationMatrix(), translation};
  }
};

}  // namespace caustic::geometry
