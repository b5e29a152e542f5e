// Sums and products of vectors of intervals.
#pragma once

#include "geometry/enclosure.h"

namespace caustic::geometry {

inline IntervalVec3 operator-(const IntervalVec3& a, const IntervalVec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline IntervalVec3 operator*(const Interval& k, const IntervalVec3& a) {
  return {k * a[0], k * a[1], k * a[2]};
}
inline Interval dot(const IntervalVec3& a, const IntervalVec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline IntervalVec3 cross(const IntervalVec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace caustic::geometry
