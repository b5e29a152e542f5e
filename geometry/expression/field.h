// A scalar field written as an expression: parsed and differentiated once, then run as programs
// that compute only what is asked for. World axes of its own frame, metres.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "geometry/enclosure.h"
#include "geometry/expression/program.h"
#include "geometry/root_finding.h"

namespace caustic::geometry {

/// A field's graph, before it is differentiated.
struct Expression {
  Graph graph;
  Graph::Id root = -1;
  std::string fault;  ///< what is wrong with the text; then there is no graph

  bool constant() const { return graph.is_constant(root); }
  bool undefined() const { return constant() && graph[root].c != graph[root].c; }
};
/// x, y and z in units of `metres`.
Expression read_expression(std::string_view text, double metres);

class Field {
 public:
  /// factor × the expression.
  Field(Expression expression, double factor);

  double value(const Point& x) const;
  double value_gradient(const Point& x, Vec3& gradient) const;
  double derivatives(const Point& x, Vec3& gradient, Mat3& hessian) const;
  Vec3 third_derivative(const Point& x, const Vec3& u, const Vec3& v) const;
  /// (u, u), (u, v) and (v, v) at once.
  std::array<Vec3, 3> third_derivatives(const Point& x, const Vec3& u, const Vec3& v) const;
  /// g, ∂g/∂x_k and ∂²g/∂x_k² at x.
  std::array<double, 3> along_axis(const Point& x, int k) const;
  bool third_derivative_vanishes() const { return third_vanishes_; }

  /// False if the field is not defined everywhere on the box; the ranges hold where it is.
  bool enclose(const IntervalVec3& x, Interval& g) const;
  bool enclose(const IntervalVec3& x, Interval& g, IntervalVec3& gradient) const;
  bool enclose(const IntervalVec3& x, SurfaceEnclosure& e) const;
  bool enclose_third(const IntervalVec3& x, IntervalSym333& third) const;

  /// True if the field is a polynomial of degree 4 at most: then this is it, along a ray.
  bool quartic() const { return degree_ >= 0 && degree_ <= 4; }
  Polynomial polynomial(const Ray& ray) const;
  /// Derivatives of order 0 to `order` <= 3 along the ray, there.
  void along(const Ray& ray, double t, int order, double* out) const;
  bool along(const Ray& ray, const Interval& t, int order, Interval* out) const;

 private:
  int degree_;
  bool third_vanishes_;
  Program value_, first_, second_, third_, thirds_, taylor_;
  std::array<Program, 4> along_;
  std::array<Program, 3> axis_;
};

}  // namespace caustic::geometry
