#include "geometry/aperture.h"

#include <algorithm>
#include <cmath>

#include "geometry/expression/expression_bound.h"

namespace caustic::geometry {

namespace {

// A ball about a box is larger than half its diagonal by what rounding may take.
constexpr double kBallRounding = 1e-12;

// The part of x − p that a round bound measures: across the axis, or all of it.
Vec3 radial(const Bound& b, const Point& x) {
  const Vec3 y = x - b.point;
  return b.kind == Bound::Kind::cylinder ? Vec3(y - b.axis * b.axis.dot(y)) : y;
}

}  // namespace

double Bound::value(const Point& x) const {
  if (kind == Kind::expression) return expression->value(x);
  if (kind == Kind::half_space) return axis.dot(x - point);
  return 0.5 * (radial(*this, x).squaredNorm() / radius - radius);
}

Vec3 Bound::gradient(const Point& x) const {
  if (kind == Kind::expression) return expression->gradient(x);
  if (kind == Kind::half_space) return axis;
  return radial(*this, x) / radius;
}

double Bound::distance(const Point& x) const {
  if (kind == Kind::expression) return expression->value(x);
  if (kind == Kind::half_space) return axis.dot(x - point);
  return radial(*this, x).norm() - radius;
}

double Bound::least_in(const Box& box) const {
  return lower_bound_within(box.center(), 0.5 * box.diagonal() * (1.0 + kBallRounding));
}

double Bound::lower_bound_within(const Point& x, double r) const {
  if (kind == Kind::expression) return expression->range(Box::around(x, r)).lo;
  if (kind == Kind::half_space) return value(x) - r;
  const double nearest = std::max(0.0, radial(*this, x).norm() - r);
  return 0.5 * (nearest * nearest / radius - radius);
}

double Bound::largest_in(const Box& box) const {
  if (kind == Kind::expression) return expression->range(box).hi;
  double largest = -kInfinity;
  for (int corner = 0; corner < 8; ++corner) {
    const auto side = [&](int i) { return corner >> i & 1 ? box.max[i] : box.min[i]; };
    largest = std::max(largest, value({side(0), side(1), side(2)}));
  }
  return largest;
}

std::vector<Bound> box_aperture(const Point& min, const Point& max) {
  std::vector<Bound> bounds;
  for (int i = 0; i < 3; ++i) {
    bounds.push_back(half_space_aperture(max, Vec3::Unit(i)));
    bounds.push_back(half_space_aperture(min, -Vec3::Unit(i)));
  }
  return bounds;
}

Bound cylinder_aperture(const Point& point, const Direction& axis, double radius) {
  return {Bound::Kind::cylinder, point, axis, radius, Bound::Origin::aperture};
}

Bound half_space_aperture(const Point& point, const Direction& normal) {
  return {Bound::Kind::half_space, point, normal, 0.0, Bound::Origin::aperture};
}

Bound expression_aperture(std::shared_ptr<const ExpressionBound> expression) {
  return {Bound::Kind::expression, Point::Zero(),        Vec3::Zero(), 0.0,
          Bound::Origin::aperture, std::move(expression)};
}

Bound ball(const Point& center, double radius, Bound::Origin origin) {
  return {Bound::Kind::ball, center, Vec3::Zero(), radius, origin};
}

bool exists_at(const std::vector<Bound>& bounds, const Point& x, double slack) {
  return std::all_of(bounds.begin(), bounds.end(),
                     [&](const Bound& b) { return b.value(x) <= slack; });
}

}  // namespace caustic::geometry
