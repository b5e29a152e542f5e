// Jets of intervals: a function with its derivatives along two coordinates, each enclosed over a
// whole cell.
#pragma once

#include "geometry/enclosure.h"
#include "geometry/jet.h"

namespace caustic::geometry {

using IntervalJet = JetOf<Interval>;
using IntervalVecJet = std::array<IntervalJet, 3>;

inline IntervalJet constant_jet(const Interval& c) { return {c, 0.0, 0.0, 0.0, 0.0, 0.0}; }

/// a², in which both factors are the same number.
inline IntervalJet square(const IntervalJet& a) {
  return {sqr(a.v),
          2.0 * a.v * a.s,
          2.0 * a.v * a.t,
          2.0 * (sqr(a.s) + a.v * a.ss),
          2.0 * (a.s * a.t + a.v * a.st),
          2.0 * (sqr(a.t) + a.v * a.tt)};
}
inline IntervalJet dot(const Vec3& a, const IntervalVecJet& x) {
  return a[0] * x[0] + a[1] * x[1] + a[2] * x[2];
}
inline IntervalJet dot(const IntervalVecJet& a, const IntervalVecJet& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline IntervalJet squared_norm(const IntervalVecJet& x) {
  return square(x[0]) + square(x[1]) + square(x[2]);
}
inline IntervalVecJet operator-(const IntervalVecJet& x, const Vec3& p) {
  IntervalVecJet y = x;
  for (std::size_t i = 0; i < 3; ++i) y[i].v -= p[static_cast<Eigen::Index>(i)];
  return y;
}

}  // namespace caustic::geometry
