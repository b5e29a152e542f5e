// The part of a surface that exists: { x : every bound(x) <= 0 }. Each bound is smooth, so that the
// end of a curve at it can be located by Newton's method; a box is six of them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "geometry/linear.h"

namespace caustic::geometry {

class ExpressionBound;

/// One smooth function, at most 1-Lipschitz near its zero set, positive where nothing exists.
///   half-space   n·(x − p)
///   cylinder     (|y|² − r²)/(2r),  y = the part of x − p across the axis
///   ball         (|x − p|² − r²)/(2r)
///   expression   (S19), infinite where it is undefined
struct Bound {
  enum class Kind { half_space, cylinder, ball, expression };
  /// Where the bound comes from: the user's aperture, the end of the shape's own definition, or the
  /// clip ball of an unbounded surface.
  enum class Origin { aperture, shape, clip };

  Kind kind;
  Point point;
  Direction axis;  ///< normal of the half-space, axis of the cylinder
  double radius = 0.0;
  Origin origin = Origin::aperture;
  std::shared_ptr<const ExpressionBound> expression = nullptr;

  double value(const Point& x) const;
  Vec3 gradient(const Point& x) const;
  /// Signed distance from the zero set, m; of an expression its value, which is no more.
  double distance(const Point& x) const;
  /// Largest value in a bounded box: at one of its corners, since every kind is convex;
  /// of an expression a bound of it.
  double largest_in(const Box& box) const;
  /// Nothing in a bounded box is smaller.
  double least_in(const Box& box) const;
  /// Smallest value that the function can have within `r` of x; of an expression a bound of it.
  double lower_bound_within(const Point& x, double r) const;
};

/// Bounds of a user's aperture. Lengths in metres, world coordinates.
std::vector<Bound> box_aperture(const Point& min, const Point& max);
Bound cylinder_aperture(const Point& point, const Direction& axis, double radius);
Bound half_space_aperture(const Point& point, const Direction& normal);
Bound expression_aperture(std::shared_ptr<const ExpressionBound> expression);
Bound ball(const Point& center, double radius, Bound::Origin origin);

/// True if every bound admits x, with `slack` metres to spare on the generous side.
bool exists_at(const std::vector<Bound>& bounds, const Point& x, double slack = 0.0);

/// World box outside of which the bounds admit nothing, infinite where they do not say. Of
/// half-spaces and balls the smallest, however they are turned; of expressions nothing. (S90)
Box box_of(const std::vector<Bound>& bounds);

/// The bounded box without what expressions among the bounds exclude at its sides.
Box without_excluded_sides(Box box, const std::vector<Bound>& bounds);

}  // namespace caustic::geometry
