// How a specular path moves with its end: path Jacobians and Hessians, and the cross-section of a
// thin pencil about it. NOTATION.md (S32)–(S34).
#pragma once

#include <array>
#include <vector>

#include "solver/specular_path.h"

namespace caustic::solver {

struct PathDerivatives {
  /// ∂xᵢ/∂p for p = path.to, one per hop: [C] (2.16) for N = 1, J*ᵢ of §2.3.2 for more.
  std::vector<Mat3> jacobians;
  /// hessians[i][a](b, c) = ∂²(xᵢ)_a/∂p_b∂p_c. Empty unless asked for.
  std::vector<std::array<Mat3, 3>> hessians;
  /// (S34), m²: signed area across the ray at `to` per solid angle at `from`; 0 on a caustic.
  double determinant = 0.0;
  /// False where p lies on a caustic or a segment grazes a surface: then there are no derivatives.
  bool finite = false;
};

/// `path` must be a root of Fermat's equations.
PathDerivatives path_derivatives(const SpecularChain& chain, const SpecularPath& path,
                                 bool hessians);

/// The path to p + Δp, predicted to first and to second order and found exactly.
struct PathPrediction {
  std::vector<Point> first, second;  ///< xᵢ + Jᵢ Δp, and + ½ Hᵢ[Δp, Δp]: (S35)
  SpecularPath exact;
  bool converged = false;  ///< `exact` continues the path; else there is none, or it lies too far
  /// Largest distance of a predicted point from the exact one, m.
  double first_error = 0.0, second_error = 0.0;
};
PathPrediction perturb(const SpecularChain& chain, const SpecularPath& path,
                       const PathDerivatives& derivatives, const Vec3& shift);

}  // namespace caustic::solver
