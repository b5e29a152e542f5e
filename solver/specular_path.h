// Fermat's principle for a path over N specular points between two given ends: the equations, their
// Newton iteration, and which of their roots light does not take. NOTATION.md (S30), (S31), (S35).
#pragma once

#include <vector>

#include "geometry/surface.h"
#include "solver/optics.h"

namespace caustic::solver {

using geometry::Mat3;
using geometry::Point;
using geometry::Vec3;

/// What happens at one point of a path. `index_before` is that of the medium the light comes
/// through; for reflection both are the same.
struct SpecularHop {
  const geometry::Surface* shape;
  bool reflects = true;
  double index_before = 1.0, index_after = 1.0;
};
using SpecularChain = std::vector<SpecularHop>;

/// Index of refraction along segment k = 0 … N.
inline double index_along(const SpecularChain& chain, std::size_t k) {
  return k == 0 ? chain.front().index_before : chain[k - 1].index_after;
}

/// Points x₁ … x_N in the order of the light, with Lagrange's multipliers.
struct SpecularPath {
  Point from, to;
  std::vector<Point> x;
  std::vector<double> lambda;

  std::size_t hops() const { return x.size(); }
  /// x₀ = from, …, x_{N+1} = to.
  const Point& vertex(std::size_t i) const { return i == 0 ? from : i <= x.size() ? x[i - 1] : to; }
  /// Segment k, from vertex k to vertex k + 1.
  Vec3 segment(std::size_t k) const { return vertex(k + 1) - vertex(k); }
};

/// Unknowns (x₁, λ₁, …, x_N, λ_N), four per hop.
using PathVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 4 * kMaxHops, 1>;
using PathMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 4 * kMaxHops, 4 * kMaxHops>;

/// Residual F of (S30) and its symmetric, block tridiagonal derivative A.
struct FermatSystem {
  PathVector F;
  PathMatrix A;
};
FermatSystem fermat_system(const SpecularChain& chain, const SpecularPath& path);

/// Σ n_k |x_{k+1} − x_k|.
double optical_length(const SpecularChain& chain, const SpecularPath& path);

/// The multipliers that fit given points best.
void fit_multipliers(const SpecularChain& chain, SpecularPath& path);

/// Newton's iteration on (S30). `converged` says that the last step was rounding; only then is the
/// path one. It may be a wrong root (see `obeys_optics`).
struct PolishResult {
  SpecularPath path;
  bool converged = false;
  int iterations = 0;
};
PolishResult polish(const SpecularChain& chain, SpecularPath start);

/// (S31): (n·ω)(n·ω′) < 0 at reflections, > 0 at refractions. Fermat's equations hold as well where
/// a straight line crosses a mirror and where refraction would send the light back.
bool obeys_optics(const SpecularChain& chain, const SpecularPath& path);

}  // namespace caustic::solver
