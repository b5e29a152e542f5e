// A smooth surface { x : g(x) = 0 } with what tracing needs: derivatives of g, all crossings of a
// ray, and charts that cover it. g is a length: near the surface |∇g| is of order one, so that
// g/|∇g| is the distance to the surface to first order. Inside, g < 0.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/aperture.h"
#include "geometry/chart.h"
#include "geometry/enclosure.h"
#include "geometry/linear.h"
#include "geometry/pose.h"

namespace caustic::geometry {

/// g, ∇g and the Hessian at one point.
struct SurfaceDerivatives {
  double g;
  Vec3 gradient;
  Mat3 hessian;
};

/// T(u, u), T(u, v) and T(v, v) for the third derivative T.
struct ThirdDerivatives {
  Vec3 uu, uv, vv;
};

/// Parameters along a ray, increasing. A fixed capacity would do for every shape but aspheres.
using RayParameters = std::vector<double>;

class Surface {
 public:
  virtual ~Surface() = default;

  virtual double value(const Point& x) const = 0;
  /// g and ∇g only: what walking to the surface needs.
  virtual double value_gradient(const Point& x, Vec3& gradient) const = 0;
  virtual SurfaceDerivatives derivatives(const Point& x) const = 0;
  /// Σ_jk g_ijk u_j v_k, the third derivative contracted twice. Zero for planes and quadrics.
  virtual Vec3 third_derivative(const Point& x, const Vec3& u, const Vec3& v) const = 0;
  /// All that two directions ask for at a point.
  virtual ThirdDerivatives third_derivatives(const Point& x, const Vec3& u, const Vec3& v) const {
    return {third_derivative(x, u, u), third_derivative(x, u, v), third_derivative(x, v, v)};
  }
  /// Ranges of g, ∇g and the Hessian over a box, up to the rounding of the surface's own constants.
  virtual SurfaceEnclosure enclose(const IntervalVec3& x) const = 0;
  /// Ranges of the third derivative over a box, in the same sense.
  virtual IntervalSym333 enclose_third(const IntervalVec3&) const {
    IntervalSym333 ranges;
    ranges.fill(at_most_quadratic() ? Interval(0.0) : Interval::whole());
    return ranges;
  }
  /// True for planes: light that leaves one does not meet it again.
  virtual bool flat() const { return false; }
  /// True if the third derivative vanishes identically.
  virtual bool at_most_quadratic() const = 0;

  /// All τ in [t0, t1] with g(ray(τ)) = 0, appended in increasing order. Bounds are not looked at.
  virtual void crossings(const Ray& ray, double t0, double t1, RayParameters& out) const = 0;
  /// All τ in [t0, t1] where g along the ray is stationary: where two crossings meet or part.
  virtual void stationary(const Ray& ray, double t0, double t1, RayParameters& out) const = 0;

  /// True if { side·g <= 0 } is known to be convex (side = ±1): light on the other side is neither
  /// shadowed by this surface nor meets it again after reflection.
  virtual bool convex(int side) const = 0;
  /// World box of the whole surface, infinite where unbounded.
  virtual Box bounds() const = 0;
  /// Bounds that belong to the shape itself (the last radius of a conic).
  virtual std::vector<Bound> own_bounds() const { return {}; }
  /// Charts that together cover the part of the surface inside `extent.region`.
  virtual std::vector<Chart> charts(const Extent& extent) const = 0;
};

using SurfacePtr = std::shared_ptr<const Surface>;

/// Factories. Lengths in metres and positive, axes and normals unit vectors, angles in radians,
/// world coordinates: a pose is applied to the parameters before.
SurfacePtr make_plane(const Point& point, const Normal& normal);
SurfacePtr make_sphere(const Point& center, double radius);
/// Axes of the ellipsoid are the columns of `rotation`.
SurfacePtr make_ellipsoid(const Point& center, const Vec3& semi_axes, const Mat3& rotation);
SurfacePtr make_cylinder(const Point& point, const Direction& axis, double radius);
/// Both nappes; 0 < half_angle < π/2.
SurfacePtr make_cone(const Point& apex, const Direction& axis, double half_angle);
/// 0 < minor_radius < major_radius.
SurfacePtr make_torus(const Point& center, const Direction& axis, double major_radius,
                      double minor_radius);
/// Height along the axis r²/(R(1+√(1−(1+k)r²/R²))) + A4 r⁴ + A6 r⁶ + …; R ≠ 0 of either sign;
/// aspheric[i] is A_{4+2i} in m^{−3−2i}.
SurfacePtr make_conic(const Point& vertex, const Direction& axis, double radius_of_curvature,
                      double conic_constant, const std::vector<double>& aspheric);

/// Ax²+By²+Cz²+2Dxy+2Exz+2Fyz+2Gx+2Hy+2Iz+J in metres, before the pose. `surface` is null, and
/// `fault` says why, if the zero set holds no regular surface (no real point, a double plane, …).
struct QuadricResult {
  SurfacePtr surface;
  std::string fault;
};
QuadricResult make_quadric(const std::array<double, 10>& coefficients, const Pose& pose);

/// Radius Σ profile[i] (z/height)^i at height z in [0, height] along the axis, at most kMaxProfileDegree + 1
/// coefficients in metres. It must be positive between the ends, where it may be zero: `surface` is
/// null, and `fault` says why, if it is not.
constexpr int kMaxProfileDegree = 20;
struct RevolutionResult {
  SurfacePtr surface;
  std::string fault;
};
RevolutionResult make_revolution(const Point& origin, const Direction& axis, double height,
                                 const std::vector<double>& profile);

/// The zero set of an expression inside a box; both are in a frame that `pose` takes to the world, in
/// metres. `surface` is null, and `fault` says why, if there is none.
struct Expression;
struct ExpressionResult {
  SurfacePtr surface;
  std::string fault;
  bool of_expression;  ///< the fault is the expression's, not its bounds'
};
ExpressionResult make_expression(const Expression& expression, const Box& bounds, const Pose& pose);

}  // namespace caustic::geometry
