// A thin pencil of light sent through a list of surfaces, without a receiver: where the ray goes
// after the last of them, and how that changes with the first hit. NOTATION.md (S36).
#pragma once

#include <array>
#include <vector>

#include "solver/light.h"
#include "solver/optical_system.h"
#include "solver/specular_path.h"

namespace caustic::solver {

using geometry::Direction;

/// A surface as one hop of a family: light comes to it from either side.
struct PathSurface {
  const geometry::Surface* shape;
  const std::vector<geometry::Bound>* bounds;
  geometry::Box region;  ///< of the part that exists
  bool reflects = true;
  double index_outside = 1.0, index_inside = 1.0;
};
PathSurface path_surface(const SystemSurface& surface);

/// The ray after the last hop, and its derivatives with respect to the first hit in ambient space.
struct Pencil {
  Point o;  ///< last hit
  Direction w;
  Mat3 dx, dw;  ///< ∂o/∂x₁, ∂w/∂x₁
  std::array<Point, kMaxHops> hits;
  /// Where a ray is lost that misses surface `missed`, all of the above is as it was before; −1
  /// otherwise.
  int missed = -1;
};

class PencilTracer {
 public:
  /// `reach` is how far a ray is followed, m.
  PencilTracer(std::vector<PathSurface> surfaces, Light light, double reach);

  const std::vector<PathSurface>& surfaces() const { return surfaces_; }
  const PathSurface& first() const { return surfaces_.front(); }
  std::size_t hops() const { return surfaces_.size(); }
  const Light& light() const { return light_; }

  /// False where the ray misses a surface, is totally reflected instead of refracted, or starts
  /// where the light is. A later surface is met where it first exists on the ray, or else where the
  /// ray comes nearest to that: so the pencil goes on smoothly beyond apertures.
  bool trace(const Point& x, Pencil& pencil) const { return follow<true>(x, pencil); }
  /// Without derivatives.
  bool trace_ray(const Point& x, Pencil& pencil) const { return follow<false>(x, pencil); }

  /// What Fermat's principle is told about a path over these hits: sides and indices.
  SpecularChain chain(const std::vector<Point>& hits) const;
  /// Light's direction at x, not normalised.
  Vec3 incident(const Point& x) const;

 private:
  template <bool differential>
  bool follow(const Point& x, Pencil& pencil) const;
  bool next_hit(const PathSurface& surface, const geometry::Ray& ray, double& t) const;

  std::vector<PathSurface> surfaces_;
  Light light_;
  double reach_;
};

}  // namespace caustic::solver
