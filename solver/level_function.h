// What a curve is the zero of: f = a − kρσ on the mirror (S9). k = parity/E₀; the caustic is k = 0.
#pragma once

#include <cmath>

#include "solver/forward_map.h"

namespace caustic::solver {

struct LevelFunction {
  double k = 0.0;

  static LevelFunction isolux(double level, int parity) { return {parity / level}; }
  static LevelFunction caustic() { return {0.0}; }

  bool is_caustic() const { return k == 0.0; }
  double value(const FieldPoint& f) const { return f.a - k * f.flux; }
  Vec3 gradient(const FieldPoint& f) const { return f.grad_a - k * f.grad_flux; }

  /// |E/E₀ − 1| on a level; |a|/(|∇q₁||∇q₂|) on the caustic.
  double residual(const FieldPoint& f) const {
    if (is_caustic()) return std::abs(f.a) / f.scale_of_a();
    return std::abs(k * f.flux / f.a - 1.0);
  }
  /// How much a rounding error `dx` of x alone moves the residual (S14).
  double residual_of_rounding(const FieldPoint& f, double dx) const {
    const double slope = gradient(f).norm();
    return slope * dx / (is_caustic() ? f.scale_of_a() : std::abs(f.a));
  }
  /// Unit tangent of the curve, n × ∇f/|∇f| (S10); zero where ∇f vanishes.
  Vec3 tangent(const FieldPoint& f) const {
    const Vec3 across = f.n.cross(gradient(f));
    const double length = across.norm();
    return length > 0.0 ? Vec3(across / length) : Vec3::Zero();
  }
};

}  // namespace caustic::solver
