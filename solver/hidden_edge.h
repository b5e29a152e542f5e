// The edge of what one surface hides of a family's light, as a smooth function on the first surface
// (S56): where a segment of the path touches the surface, passes the edge of its aperture, or
// begins or ends on it.
#pragma once

#include <vector>

#include "solver/contours.h"
#include "solver/forward_map.h"

namespace caustic::solver {

/// What hides, and how it begins to. Segments are numbered from the light: 0 ends on the first
/// surface.
struct Hiding {
  enum class Kind {
    touch,  ///< the segment is tangent to the surface
    rim,    ///< it passes the edge of the aperture
    point   ///< its beginning or end lies on the surface
  };
  Kind kind;
  int segment;
  int surface;
  const geometry::Bound* bound = nullptr;  ///< of a rim
  int point = 0;                           ///< of Kind::point: 0 the light, 1 the first hit, …
  bool same_function(const Hiding& other) const {
    return kind == other.kind && surface == other.surface && bound == other.bound &&
           (kind == Kind::point ? point == other.point : segment == other.segment);
  }
};

/// One for each curve. It remembers where along the segment it was found last, which tells several
/// touches of one segment apart; so it is not thread-safe.
class HiddenEdge {
 public:
  /// `y` is the place where the path of `f`, nearly about to be hidden, comes to the surface. What
  /// is found is remembered at every `spacing`, m. The map must outlive the edge.
  HiddenEdge(const ForwardMap& map, const Hiding& hiding, const FieldPoint& f, const Point& y,
             double spacing);

  const ForwardMap& map() const { return map_; }
  const Hiding& hiding() const { return hiding_; }
  Ending ending() const { return hiding_.segment == 0 ? Ending::shadow : Ending::occlusion; }

  /// h, m, of a sign that depends on the surface; NaN where there is no such place.
  double value(const FieldPoint& f) const { return solve(f).h; }
  /// ∇h along the first surface.
  Vec3 gradient(const FieldPoint& f) const { return solve(f).gradient; }
  /// Where on the surface.
  const Point& place(const FieldPoint& f) const { return solve(f).y; }
  /// The side of the surface, ±1, on which the segment passes a touch, or ends at a point.
  int side(const FieldPoint& f) const;
  /// Functions, m, that change their sign where the edge stops being one: the other bounds of the
  /// aperture, the ends of the segment, and on a rim or a point where the segment touches the
  /// surface.
  std::vector<double> limits(const FieldPoint& f) const;
  /// False where it hides nothing since there is no surface, or not on the segment.
  bool possible(const FieldPoint& f) const;

 private:
  struct State {
    Point x;   // first hit
    double t;  // share of the segment
    Point y;   // place on the surface
    double h = 0.0;
    Vec3 gradient = Vec3::Zero();
    Vec3 gradient_t = Vec3::Zero();  // of t along the first surface, of a touch
  };
  struct Moving {  // a place as a function of (s, t)
    Point at;
    Vec3 s, t;
  };
  Moving point_of_path(const FieldPoint& f, int k) const;
  const State& solve(const FieldPoint& f) const;
  State solved(const FieldPoint& f, State guess) const;
  bool touch(const Moving& a, const Moving& b, State& state) const;
  bool rim(const Moving& a, const Moving& b, State& state) const;
  const SystemSurface& blocker() const { return map_.system().surfaces()[hiding_.surface]; }

  const ForwardMap& map_;
  Hiding hiding_;
  double reach_ = 0.0;  // of a beam's segment, m
  double spacing_;
  mutable std::vector<State> known_;
  mutable State last_;
};

}  // namespace caustic::solver
