// An aperture given by an expression f, kept where f <= 0, as a bound: a length that is at most
// 1-Lipschitz near the zero set.
#pragma once

#include "geometry/expression/field.h"

namespace caustic::geometry {

/// (S19) h = f/√(G² + |∇f|²) with G the typical |∇f| on the zero set: smooth where ∇f vanishes,
/// f/|∇f| where that is large. Infinite where f is undefined: nothing exists there.
class ExpressionBound {
 public:
  /// Lengths of the order of `scale` are where the zero set is looked for, m.
  ExpressionBound(const Expression& expression, double scale);

  double value(const Point& x) const;
  Vec3 gradient(const Point& x) const;
  /// Range of its values on a bounded box; where it is undefined they are infinite.
  Interval range(const Box& box) const;

 private:
  Field f_;
  double typical_;  // G
};

}  // namespace caustic::geometry
