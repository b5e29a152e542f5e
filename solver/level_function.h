// What a curve is the zero of: f = a − kρσ on the first surface (S9), k = parity/E₀, the caustic being
// k = 0; or the function h of one of the domain's boundaries (S12) or of the edge of what hides (S56).
#pragma once

#include <cmath>

#include "solver/domain.h"
#include "solver/hidden_edge.h"

namespace caustic::solver {

struct LevelFunction {
  double k = 0.0;
  const Domain* domain = nullptr;  ///< of a boundary; must outlive this
  int boundary = -1;
  const HiddenEdge* edge = nullptr;  ///< must outlive this

  static LevelFunction isolux(double level, int parity) { return {parity / level}; }
  static LevelFunction caustic() { return {0.0}; }
  static LevelFunction boundary_of(const Domain& domain, int i) { return {0.0, &domain, i}; }
  static LevelFunction edge_of(const HiddenEdge& edge) { return {0.0, nullptr, -1, &edge}; }

  bool is_isolux() const { return k != 0.0; }
  bool is_boundary() const { return boundary >= 0 || edge; }
  bool is_caustic() const { return !is_isolux() && !is_boundary(); }

  double value(const FieldPoint& f) const {
    if (edge) return edge->value(f);
    return is_boundary() ? domain->value(boundary, f) : f.a - k * f.flux;
  }
  Vec3 gradient(const FieldPoint& f) const {
    if (edge) return edge->gradient(f);
    if (!is_boundary()) return f.grad_a - k * f.grad_flux;
    const Vec3 slope = domain->gradient(boundary, f);
    return slope - f.n * f.n.dot(slope);
  }

  /// |E/E₀ − 1| on a level; |a|/(|∇q₁||∇q₂|) on the caustic; |h| in widths of the receiver.
  double residual(const FieldPoint& f) const {
    if (is_isolux()) return std::abs(k * f.flux / f.a - 1.0);
    return std::abs(value(f)) / unit(f);
  }
  /// How much a rounding error `dx` of x alone moves the residual (S14).
  double residual_of_rounding(const FieldPoint& f, double dx) const {
    return gradient(f).norm() * dx / (is_isolux() ? std::abs(f.a) : unit(f));
  }
  /// Unit tangent of the curve, n × ∇f/|∇f| (S10); zero where ∇f vanishes.
  Vec3 tangent(const FieldPoint& f) const {
    const Vec3 across = f.n.cross(gradient(f));
    const double length = across.norm();
    return length > 0.0 ? Vec3(across / length) : Vec3::Zero();
  }

 private:
  double unit(const FieldPoint& f) const {
    if (edge) return edge->map().receiver().width();
    return is_boundary() ? domain->map().receiver().width() : f.scale_of_a();
  }
};

}  // namespace caustic::solver
