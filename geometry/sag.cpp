#include "geometry/sag.h"

#include "geometry/rotated_third.h"

namespace caustic::geometry {

double SagSurface::value(const Point& x) const {
  const Vec3 y = local(x);
  return y.z() - height(y.x(), y.y());
}

double SagSurface::value_gradient(const Point& x, Vec3& gradient) const {
  const Vec3 y = local(x);
  Vec2 slope;
  const double g = y.z() - height_slope(y.x(), y.y(), slope);
  gradient = axes_ * Vec3(-slope.x(), -slope.y(), 1.0);
  return g;
}

SurfaceDerivatives SagSurface::derivatives(const Point& x) const {
  const Vec3 y = local(x);
  const HeightJet h = height_jet(y.x(), y.y());
  Mat3 H = Mat3::Zero();
  H.topLeftCorner<2, 2>() << -h.d2[0], -h.d2[1], -h.d2[1], -h.d2[2];
  return {y.z() - h.f, axes_ * Vec3(-h.d1[0], -h.d1[1], 1.0), axes_ * H * axes_.transpose()};
}

Vec3 SagSurface::contracted(const HeightJet& h, const Vec3& u, const Vec3& v) const {
  const auto& d = h.d3;
  const Vec2 a = (axes_.transpose() * u).head<2>(), b = (axes_.transpose() * v).head<2>();
  const double xx = a.x() * b.x(), xy = a.x() * b.y() + a.y() * b.x(), yy = a.y() * b.y();
  return axes_ * -Vec3(d[0] * xx + d[1] * xy + d[2] * yy, d[1] * xx + d[2] * xy + d[3] * yy, 0.0);
}

Vec3 SagSurface::third_derivative(const Point& x, const Vec3& u, const Vec3& v) const {
  const Vec3 y = local(x);
  return contracted(height_jet(y.x(), y.y()), u, v);
}

// The jet is what takes time.
ThirdDerivatives SagSurface::third_derivatives(const Point& x, const Vec3& u, const Vec3& v) const {
  const Vec3 y = local(x);
  const HeightJet h = height_jet(y.x(), y.y());
  return {contracted(h, u, u), contracted(h, u, v), contracted(h, v, v)};
}

SurfaceEnclosure SagSurface::enclose(const IntervalVec3& x) const {
  const IntervalVec3 y = transposed(axes_, x - o_);
  const HeightRanges f = height_ranges(y[0], y[1]);
  SurfaceEnclosure e{y[2] - f[0], {-f[1], -f[2], 1.0}, {-f[3], -f[4], 0.0, -f[5], 0.0, 0.0}};
  return rotated(e, axes_);
}

IntervalSym333 SagSurface::enclose_third(const IntervalVec3& x) const {
  const IntervalVec3 y = transposed(axes_, x - o_);
  const ThirdRanges f = height_third_ranges(y[0], y[1]);
  IntervalSym333 third;
  third.fill(Interval(0.0));
  third[packed_index(0, 0, 0)] = -f[0];
  third[packed_index(0, 0, 1)] = -f[1];
  third[packed_index(0, 1, 1)] = -f[2];
  third[packed_index(1, 1, 1)] = -f[3];
  return rotated(third, axes_);
}

}  // namespace caustic::geometry
