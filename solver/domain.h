// Where curves of a family exist, as smooth functions that are positive where they do not (S12):
// aperture bounds, silhouette, the receiver's plane, the receiver's edges. What other surfaces hide
// is not part of it: see visibility.h.
#pragma once

#include "solver/contours.h"
#include "solver/forward_map.h"

namespace caustic::solver {

class Domain {
 public:
  explicit Domain(const ForwardMap& map) : map_(map), bounds_(map.mirror().bounds) {}

  const ForwardMap& map() const { return map_; }
  /// Boundaries are numbered 0 … size() − 1.
  int size() const { return bound_count() + 6; }
  /// h at a point, a length; ≤ 0 inside.
  double value(int i, const FieldPoint& f) const;
  /// h as a function of the place alone, where it is one: aperture bounds; null otherwise.
  const geometry::Bound* bound(int i) const { return i < bound_count() ? &bounds_[i] : nullptr; }
  /// ∇h; its part along the surface is what counts.
  Vec3 gradient(int i, const FieldPoint& f) const;
  /// ∇h·t for a direction t in the surface, with dq = M t.
  double slope(int i, const FieldPoint& f, const Vec3& t, const Vec2& dq) const;
  /// What h changes no faster than: the place x, its image q, or neither.
  enum class Slope { of_place, of_image, unknown };
  Slope slope_bound(int i) const {
    if (i == bound_count()) return Slope::unknown;
    return i <= bound_count() + 1 ? Slope::of_place : Slope::of_image;
  }
  Ending ending(int i) const;
  /// True for the ball in which unbounded surfaces exist.
  bool is_clip(int i) const {
    return i < bound_count() && bounds_[i].origin == geometry::Bound::Origin::clip;
  }
  /// The boundary furthest outside at f, and by how much; {0, value} may be negative (inside).
  struct Worst {
    int boundary;
    double value;
  };
  Worst worst(const FieldPoint& f) const;
  bool contains(const FieldPoint& f) const { return f.arrives() && worst(f).value <= 0.0; }

 private:
  int bound_count() const { return static_cast<int>(bounds_.size()); }

  const ForwardMap& map_;
  const std::vector<geometry::Bound>& bounds_;
};

}  // namespace caustic::solver
