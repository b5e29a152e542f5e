// Boxes as vectors of intervals, and what a surface encloses over one.
#pragma once

#include <array>
#include <utility>

#include "geometry/interval.h"
#include "geometry/linear.h"

namespace caustic::geometry {

using IntervalVec3 = std::array<Interval, 3>;
/// Upper half of a symmetric matrix: xx xy xz yy yz zz.
using IntervalSym3 = std::array<Interval, 6>;
constexpr std::array<std::pair<int, int>, 6> kPackedIndices{
    {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};

/// Every value that g, ∇g and the Hessian take on a box.
struct SurfaceEnclosure {
  Interval g;
  IntervalVec3 gradient;
  IntervalSym3 hessian;
};

/// A symmetric tensor of third order: xxx xxy xxz xyy xyz xzz yyy yyz yzz zzz.
using IntervalSym333 = std::array<Interval, 10>;
constexpr std::size_t packed_index(int i, int j, int k) {
  const int beyond_x = (i > 0) + (j > 0) + (k > 0), z = (i == 2) + (j == 2) + (k == 2);
  return static_cast<std::size_t>(beyond_x * (beyond_x + 1) / 2 + z);
}

inline IntervalVec3 intervals(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
inline IntervalVec3 intervals(const Box& box) {
  return {Interval(box.min.x(), box.max.x()), Interval(box.min.y(), box.max.y()),
          Interval(box.min.z(), box.max.z())};
}
inline Box box_of(const IntervalVec3& x) {
  return {{x[0].lo, x[1].lo, x[2].lo}, {x[0].hi, x[1].hi, x[2].hi}};
}
inline IntervalSym3 packed(const Mat3& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
}

inline IntervalVec3 operator-(const IntervalVec3& x, const Vec3& p) {
  return {x[0] - p[0], x[1] - p[1], x[2] - p[2]};
}
inline Interval dot(const Vec3& a, const IntervalVec3& x) {
  return a[0] * x[0] + a[1] * x[1] + a[2] * x[2];
}
inline Interval squared_norm(const IntervalVec3& x) { return sqr(x[0]) + sqr(x[1]) + sqr(x[2]); }
inline IntervalVec3 operator*(const Mat3& m, const IntervalVec3& x) {
  return {dot(m.row(0), x), dot(m.row(1), x), dot(m.row(2), x)};
}
/// mᵀ x.
inline IntervalVec3 transposed(const Mat3& m, const IntervalVec3& x) {
  return {dot(m.col(0), x), dot(m.col(1), x), dot(m.col(2), x)};
}

/// m S mᵀ.
inline IntervalSym3 congruent(const Mat3& m, const IntervalSym3& s) {
  const IntervalVec3 rows[3] = {m * IntervalVec3{s[0], s[1], s[2]},
                                m * IntervalVec3{s[1], s[3], s[4]},
                                m * IntervalVec3{s[2], s[4], s[5]}};  // rows of S mᵀ
  IntervalSym3 out;
  for (int k = 0; k < 6; ++k) {
    const auto [i, j] = kPackedIndices[k];
    out[k] = dot(m.row(i), IntervalVec3{rows[0][j], rows[1][j], rows[2][j]});
  }
  return out;
}
/// The same from a frame whose axes are the columns of m to the world.
inline SurfaceEnclosure rotated(const SurfaceEnclosure& e, const Mat3& m) {
  return {e.g, m * e.gradient, congruent(m, e.hessian)};
}

}  // namespace caustic::geometry
