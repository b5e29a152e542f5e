// A second road to every number, in 50-digit arithmetic, sharing no formula with the program:
// implicit functions as distances where the program has polynomials, Snell and Fresnel with unit
// vectors, ambient central differences where the program has jets in a tangent frame.
#pragma once

#include <vector>

#include "geometry/linear.h"
#include "geometry/receiver_frame.h"
#include "solver/light.h"
#include "solver/optics.h"
#include "tests/support/shape_zoo.h"

namespace caustic::test {

using geometry::Mat3;
using geometry::Point;
using geometry::Vec2;
using geometry::Vec3;

/// Geometry of the level surface through a point; n points to where g > 0.
struct ReferenceShape {
  double distance;  ///< g/|∇g|
  Vec3 normal;
  Mat3 curvature;  ///< P H P/|∇g|: ∂n along the surface
};
ReferenceShape reference_shape(const ShapeSpec& spec, const Point& x);

/// Sign and size of g/|∇g| at origin + τ·direction, in extended precision.
class ReferenceRay {
 public:
  ReferenceRay(const ShapeSpec& spec, const geometry::Ray& ray);
  double distance(double t) const;
  /// Roots in [t0, t1]: sign changes on `samples` intervals, and on intervals beside a local
  /// minimum of |distance| searched more finely; bisected.
  std::vector<double> roots(double t0, double t1, int samples) const;

 private:
  long double value(long double t) const;
  const ShapeSpec* spec_;
  geometry::Ray ray_;
};

/// The map x ↦ q and what follows from it, rounded from 50 digits.
struct ReferenceField {
  Vec2 q;
  double a, scale_of_a;        ///< scale |∇q₁||∇q₂|, gradients along the surface
  Vec3 grad_a;                 ///< along the surface
  double scale_of_grad_a;      ///< sum of the absolute values of its terms
  double flux, scale_of_flux;  ///< scale: the flux density at cos α = 1
  Vec3 grad_flux;              ///< along the surface
  double scale_of_grad_flux;   ///< bending of the surface and falloff, in absolute values
  double incidence;            ///< m·ω' of the unit reflected direction
  double curvature;            ///< √(κ₁² + κ₂²) of the mirror
};

/// A later bounce; its hit is the root next to `distance` from the one before.
struct ReferenceHop {
  ShapeSpec shape;
  int side;
  solver::Optics optics;
  double distance = 0.0;
};

struct ReferenceScene {
  ShapeSpec shape;
  int side;
  double reflectance;
  solver::Light light;
  geometry::ReceiverFrame receiver;
  solver::Optics optics = {};  ///< of the first surface; `reflectance` counts besides
  std::vector<ReferenceHop> later = {};
};
ReferenceField reference_field(const ReferenceScene& scene, const Point& x);

/// E = ρσ/|a| only: cheaper.
double reference_irradiance(const ReferenceScene& scene, const Point& x);

}  // namespace caustic::test
