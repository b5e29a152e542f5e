// One bounce of a path: how light leaves a surface, where it meets the next one, and how both
// change with the first hit. NOTATION.md (S23)–(S25).
#pragma once

#include <optional>
#include <vector>

#include "geometry/jet.h"
#include "solver/optical_system.h"

namespace caustic::solver {

using geometry::Point;
using geometry::Vec3;
using VecJet = geometry::JetOf<Vec3>;

/// Reflection or refraction, as the surface's optics has it.
struct Hop {
  int surface;
  int side;  ///< s = ±1: light comes from where s·g > 0
  auto operator<=>(const Hop&) const = default;
};
/// Ordered, at most kMaxHops.
using Hops = std::vector<Hop>;

/// Direction after the bounce, of the same length as d; N = ∇g at the hit. None if all is reflected
/// where light should pass.
std::optional<Vec3> bend(const Optics& optics, int side, const Vec3& d, const Vec3& N);

/// τ > least where the ray comes to the surface from `side`. Of several places the first that
/// exists, or else the one that comes nearest to existing; with `guess`, the one that the guess
/// belongs to, whether it exists or not. None if the ray misses.
std::optional<double> next_hit(const SystemSurface& surface, int side, const geometry::Ray& ray,
                               double least, const double* guess);
/// The least τ of a hit on the surface where the ray begins: rounding may leave that place itself
/// at a positive τ.
double least_return(const geometry::Ray& ray, double scale);

/// Position and unnormalised direction of a ray as functions of (s, t).
struct RayJet {
  VecJet x, d;
};
/// Surface normal ∇g along the surface through ray.x; `third` if the third derivative of g counts.
VecJet normal_jet(const geometry::Surface& shape, const geometry::SurfaceDerivatives& at,
                  const VecJet& x, bool third);
/// Moves the ray's position on to where it meets the surface, τ being known.
void transfer(RayJet& ray, double tau, const geometry::SurfaceDerivatives& at);

/// What the bounce does besides turning the direction.
struct Bounce {
  geometry::Jet cosine;    ///< of incidence
  geometry::Jet headroom;  ///< ξ of (S24), cos² of refraction; 1 for mirrors
};
/// Turns ray.d. False, and ray unchanged, where all is reflected that should pass.
bool bend(const Optics& optics, int side, const VecJet& N, RayJet& ray, Bounce& bounce);

}  // namespace caustic::solver
