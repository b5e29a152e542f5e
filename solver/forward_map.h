// The map x ↦ q of one family, from the first hit on its mirror to the receiver, with the closed-form
// derivatives that give irradiance and its gradient. NOTATION.md (S1)–(S7).
#pragma once

#include "geometry/linear.h"
#include "solver/optical_system.h"

namespace caustic::solver {

using geometry::Direction;
using geometry::Normal;
using geometry::Point;
using geometry::Vec2;
using geometry::Vec3;

/// All that tracing asks about one point of the mirror. Gradients lie in the tangent plane at x.
struct FieldPoint {
  Point x;
  Normal n;            ///< towards the lit side
  Direction e1, e2;    ///< e1 × e2 = n
  bool finite = false; ///< false where g has no normal, the light is at x, or numbers overflow
  double lambda = 0;   ///< arrives if > 0 (S4), in lengths of d
  double facing = 0;   ///< m·D; its sign changes at a pole

  Vec2 q = Vec2::Zero();
  Vec2 q_s, q_t;       ///< columns of M = ∂q/∂(s, t)
  double a = 0;
  Vec3 grad_a;
  double flux = 0;     ///< ρσ, W/m², negative on the dark side
  Vec3 grad_flux;
  double cos_alpha = 0;
  Vec3 grad_cos;

  bool arrives() const { return finite && lambda > 0.0; }
  bool lit() const { return cos_alpha > 0.0; }
  /// Signed inverse irradiance φ.
  double inverse_irradiance() const { return a / flux; }
  double irradiance() const { return flux / std::abs(a); }
  /// The natural scale of a: |∇q₁||∇q₂|, but no less than kLeastScale of the squared stretch, since on
  /// a caustic whose image runs along a receiver axis one of the two vanishes with a.
  double scale_of_a() const;
  /// True where a is zero to rounding against the stretch of the map, or the map shrinks all to a
  /// point: light that is focused perfectly, or sampled right on a caustic.
  bool looks_degenerate() const;
  /// (∂E/∂q₁, ∂E/∂q₂), (S7).
  Vec2 irradiance_gradient() const;
  /// Gradient of φ along the surface.
  Vec3 inverse_irradiance_gradient() const { return (grad_a - (a / flux) * grad_flux) / flux; }
  /// dq for a step dx in the tangent plane.
  Vec2 push_forward(const Vec3& dx) const { return q_s * e1.dot(dx) + q_t * e2.dot(dx); }
};

/// One mirror, lit on one side, seen by the receiver: a one-bounce family.
class ForwardMap {
 public:
  /// `side` = ±1 is s of NOTATION.md. The system must outlive the map.
  ForwardMap(const OpticalSystem& system, int surface, int side);

  const SystemSurface& mirror() const { return *mirror_; }
  const geometry::Surface& shape() const { return *mirror_->shape; }
  const geometry::ReceiverFrame& receiver() const { return *receiver_; }
  int surface_index() const { return surface_; }
  int side() const { return side_; }

  /// The value alone, for comparison: q of (S4).
  Vec2 arrival(const Point& x) const;
  /// Everything, in closed form. x need not lie on the surface exactly: then the level surface of g
  /// through x takes its place.
  FieldPoint evaluate(const Point& x) const;

  /// Unnormalised direction of the light at x (d of NOTATION.md) and after reflection (D).
  Vec3 incident(const Point& x) const;
  Vec3 reflected(const Point& x) const;

  /// Flux density across the light at x, times ρ: ρI/|d|² or ρE_b, W/m².
  double flux_across(const Point& x) const {
    return point_source_ ? strength_ / (x - source_).squaredNorm() : strength_;
  }

  /// The point of the surface reached from x by Newton's steps along ∇g, to rounding.
  Point project(const Point& x) const;
  /// Rounding error of a point near x, m (S14).
  double rounding(const Point& x) const;

 private:
  const SystemSurface* mirror_;
  const geometry::ReceiverFrame* receiver_;
  int surface_, side_;
  bool point_source_;
  bool quadratic_;  // third derivatives of g vanish
  Vec3 source_;     // position or direction
  double strength_; // ρ I or ρ E_b
  double scale_;
  geometry::Mat3 to_receiver_;  // rows u, v, m
};

}  // namespace caustic::solver
