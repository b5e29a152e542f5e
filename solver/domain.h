// Where curves of a family exist, as smooth functions that are positive where they do not (S12):
// aperture bounds, silhouette, the receiver's plane, the receiver's edges, and for each hop total
// reflection and, after the first, the aperture and grazing incidence. What other surfaces hide is not
// part of it: see visibility.h.
#pragma once

#include <optional>

#include "solver/contours.h"
#include "solver/forward_map.h"

namespace caustic::solver {

class Domain {
 public:
  explicit Domain(const ForwardMap& map);
  /// The same without boundary i, which is then nowhere in the way: for curves along it.
  Domain without(int i) const {
    Domain other = *this;
    other.left_out_ = i;
    return other;
  }

  const ForwardMap& map() const { return map_; }
  /// Boundaries are numbered 0 … size() − 1.
  int size() const { return first_later() + static_cast<int>(later_.size()); }
  /// From this number on they belong to hops.
  int first_later() const { return bound_count() + 6; }
  /// Number of the silhouette of the first surface; the receiver's plane and edges follow.
  int silhouette() const { return bound_count(); }
  /// h at a point that `f` says is finite, a length; ≤ 0 inside, −∞ for what is left out.
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
    if (i < bound_count()) return Slope::of_place;
    if (i == bound_count() || i >= first_later()) return Slope::unknown;
    if (i > bound_count() + 1) return Slope::of_image;
    return map_.hop_count() <= 1 ? Slope::of_place : Slope::unknown;
  }
  Ending ending(int i) const;
  /// The first boundary that is where i is: planes may coincide.
  int first_like(int i) const;
  /// True for the ball in which unbounded surfaces exist.
  bool is_clip(int i) const {
    const geometry::Bound* bound = bound_of(i);
    return bound && bound->origin == geometry::Bound::Origin::clip;
  }
  /// The boundary furthest outside at f, and by how much; {0, value} may be negative (inside).
  struct Worst {
    int boundary;
    double value;
  };
  Worst worst(const FieldPoint& f) const;
  bool contains(const FieldPoint& f) const { return f.arrives() && worst(f).value <= 0.0; }

 private:
  // A boundary at a hop, seen on the first surface through its hit.
  struct Later {
    enum class Kind { bound, grazing, total_reflection };
    Kind kind;
    int hop;
    const geometry::Bound* bound;  // of the first kind
  };
  struct Plane {
    Vec3 normal;
    Point point;
  };
  std::optional<Plane> plane(int i) const;
  int bound_count() const { return static_cast<int>(bounds_.size()); }
  const Later* later(int i) const { return i < first_later() ? nullptr : &later_[i - first_later()]; }
  const geometry::Bound* bound_of(int i) const {
    if (i < bound_count()) return &bounds_[i];
    return later(i) ? later(i)->bound : nullptr;
  }

  // Where light leaves for the receiver.
  const Point& last(const FieldPoint& f) const {
    return map_.hop_count() == 1 ? f.x : f.hits[map_.hop_count() - 1].y;
  }

  const ForwardMap& map_;
  const std::vector<geometry::Bound>& bounds_;
  std::vector<Later> later_;
  int left_out_ = -1;
};

}  // namespace caustic::solver
