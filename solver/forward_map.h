// The map x ↦ q of one family, from the first hit on its first surface to the receiver, with the
// closed-form derivatives that give irradiance and its gradient. NOTATION.md (S1)–(S7),
// (S23)–(S27).
#pragma once

#include <memory>

#include "geometry/linear.h"
#include "solver/hop.h"
#include "solver/optical_system.h"
#include "solver/seek.h"

namespace caustic::solver {

using geometry::Direction;
using geometry::Normal;
using geometry::Point;
using geometry::Vec2;
using geometry::Vec3;

/// Where a path meets one of its surfaces, as a function of the first hit.
struct Hit {
  Point y;
  double tau;     ///< from the hop before, in lengths of its direction; 0 at the first
  Vec3 y_s, y_t;  ///< ∂y/∂(s, t)
  double cosine;  ///< of incidence
  Vec3 grad_cosine;
  double headroom;  ///< ξ of (S24): all is reflected where it is negative; 1 for mirrors
  Vec3 grad_headroom;
};

/// All that tracing asks about one point of the first surface. Gradients lie in its tangent plane.
struct FieldPoint {
  Point x;
  Normal n;             ///< towards the lit side
  Direction e1, e2;     ///< e1 × e2 = n
  bool finite = false;  ///< false where the path ends before the receiver, g has no normal, the
                        ///< light is at x, or numbers overflow
  double lambda = 0;    ///< arrives if > 0 (S4), in lengths of d
  double facing = 0;    ///< m·D; its sign changes at a pole

  Vec2 q = Vec2::Zero();
  Vec2 q_s, q_t;  ///< columns of M = ∂q/∂(s, t)
  double a = 0;
  Vec3 grad_a;
  double share = 1;  ///< what ρ has beyond its constant factors: Fresnel's share
  double flux = 0;   ///< ρσ, W/m², negative on the dark side
  Vec3 grad_flux;
  double cos_alpha = 0;
  Vec3 grad_cos;
  /// One for each hop; null for a single mirror, whose only hit is x.
  std::shared_ptr<const Hit[]> hits;

  bool arrives() const { return finite && lambda > 0.0; }
  bool lit() const { return cos_alpha > 0.0; }
  /// Signed inverse irradiance φ.
  double inverse_irradiance() const { return a / flux; }
  double irradiance() const { return flux / std::abs(a); }
  /// The natural scale of a: |∇q₁||∇q₂|, but no less than kLeastScale of the squared stretch, since
  /// on a caustic whose image runs along a receiver axis one of the two vanishes with a.
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
  /// The step in the tangent plane whose image is dq, by the path Jacobian (S7); not finite where a
  /// is zero.
  Vec3 pull_back(const Vec2& dq) const {
    const double det = q_s.x() * q_t.y() - q_t.x() * q_s.y();
    return ((q_t.y() * dq.x() - q_t.x() * dq.y()) / det) * e1 +
           ((q_s.x() * dq.y() - q_s.y() * dq.x()) / det) * e2;
  }
};

/// A family of hops. The system must outlive the map. Without hops it is the direct light (S80):
/// then the receiver's plane is the first surface, and x the point of arrival.
class ForwardMap {
 public:
  /// `all_third_derivatives`: those of quadrics too, which vanish.
  ForwardMap(const OpticalSystem& system, const Hops& hops, bool all_third_derivatives = false);
  /// One mirror; `side` = ±1 is s of NOTATION.md.
  ForwardMap(const OpticalSystem& system, int surface, int side)
      : ForwardMap(system, Hops{{surface, side}}) {}

  const OpticalSystem& system() const { return *system_; }
  const Hops& hops() const { return hops_; }
  int hop_count() const { return static_cast<int>(hops_.size()); }
  const SystemSurface& surface(int hop) const { return system_->surfaces()[hops_[hop].surface]; }
  /// The first surface: curves live on it.
  const SystemSurface& mirror() const {
    return hops_.empty() ? system_->receiver_plane() : surface(0);
  }
  const geometry::Surface& shape() const { return *mirror().shape; }
  const geometry::ReceiverFrame& receiver() const { return system_->receiver(); }
  int side() const { return side_; }

  /// Everything, in closed form. x need not lie on the surface exactly: then the level surface of g
  /// through x takes its place. Later hits are those next to the hits `near`, if given.
  FieldPoint evaluate(const Point& x, const Hit* near = nullptr) const;
  /// The value alone, for comparison: q of (S4). NaN where the path ends before the receiver.
  Vec2 arrival(const Point& x) const;
  /// The hits of the path from x, x first; false where it ends before the receiver's plane, its
  /// direction there, or zero where all is reflected that should pass.
  bool follow(const Point& x, std::vector<Point>& hits, Vec3& direction) const;

  /// How the path from x, that ends, does so.
  NearMiss near_miss(const Point& x) const;

  /// True if a path may end before the receiver: missing a surface, or by total reflection.
  bool paths_may_end() const { return !single_mirror_ && !hops_.empty(); }
  /// ρI, W/sr, or ρE_b, W/m², with the constant factors of ρ.
  double strength() const { return strength_; }
  /// Unnormalised direction of the light at x (d of NOTATION.md).
  Vec3 incident(const Point& x) const;

  /// Flux density across the light at x, times the constant factors of ρ: ρI/|d|² or ρE_b, W/m².
  double flux_across(const Point& x) const {
    return point_source_ ? strength_ / (x - source_).squaredNorm() : strength_;
  }

  /// The point of the surface reached from x by Newton's steps along ∇g, to rounding.
  Point project(const Point& x) const;
  /// Rounding error of a point near x, m (S14).
  double rounding(const Point& x) const;

 private:
  struct Start;
  void arrive_at_once(const Start& start, FieldPoint& f) const;
  void reflect_once(const Start& start, FieldPoint& f) const;
  std::optional<double> hit_after(int hop, const geometry::Ray& ray, const double* guess) const;
  bool pass_all_hops(const Start& start, const Hit* near, FieldPoint& f) const;

  const OpticalSystem* system_;
  Hops hops_;
  int side_;            // of the first surface
  bool single_mirror_;  // no later hop, ρ constant
  bool point_source_;
  bool all_third_derivatives_;
  bool quadratic_;   // third derivatives of the first g vanish, and are left out
  Vec3 source_;      // position or direction
  double strength_;  // I or E_b, times the constant factors of ρ
  double scale_;
  geometry::Mat3 to_receiver_;  // rows u, v, m
};

}  // namespace caustic::solver
