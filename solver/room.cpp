#include "solver/room.h"

#include <algorithm>
#include <cmath>

namespace caustic::solver {

using geometry::Point;
using geometry::Vec3;

namespace {

// How much larger the Hessian may be on the way than where it is asked; it is constant for
// quadrics.
constexpr double kHessianGrowth = 6.0;

// Least distance at which a function of this size may vanish that changes as g does, to second
// order: |g| <= |∇g| δ + ½ |H| δ² solved for δ. A first-order distance is too large inside of
// curved surfaces.
double distance_from(double g, const geometry::SurfaceDerivatives& d, double growth) {
  const double slope = d.gradient.norm();
  return 2.0 * g / (slope + std::sqrt(slope * slope + 2.0 * growth * g * d.hessian.norm()));
}

// A place on the segment: how far the surface is, and how far the aperture's edge.
struct Place {
  geometry::SurfaceDerivatives d;
  double distance, margin;
};

class RoomFinder {
 public:
  RoomFinder(const SystemSurface& surface, const Segment& segment, bool beam)
      : shape_(*surface.shape),
        bounds_(surface.bounds),
        segment_(segment),
        beam_(beam),
        growth_(shape_.at_most_quadratic() ? 1.0 : kHessianGrowth),
        length_(segment.ray.direction.norm()),
        along_(segment.ray.direction / length_),
        still_(touches()) {
    shape_.stationary(segment.ray, 0.0, 1.0, still_);
  }

  void look_at_ends(bool own, bool target);
  void look_at_touches();
  void look_at(double crossing);
  Room found() const { return hidden_ ? Room{true, depth_} : Room{false, free_}; }

 private:
  // Kept from call to call.
  static geometry::RayParameters& touches() {
    thread_local geometry::RayParameters still;
    still.clear();
    return still;
  }

  Place place(double t) const;
  double to_edge(const Place& at, double rise) const;
  double slope_rise(const Place& at) const;
  RoomUse use_of(double c, double lo, double hi) const;
  RoomUse until_free(double crossing, const RoomUse& edge) const;
  void meet(const Place& at, double rise, double lo, double hi);

  const geometry::Surface& shape_;
  const std::vector<geometry::Bound>& bounds_;
  const Segment& segment_;
  bool beam_;
  double growth_, length_;
  Vec3 along_;
  geometry::RayParameters& still_;
  RoomUse free_, depth_{geometry::kInfinity, geometry::kInfinity};
  RoomUse ends_;  // until an end is past the surface
  bool hidden_ = false;
};

Place RoomFinder::place(double t) const {
  const Point y = segment_.ray.at(t);
  const auto d = shape_.derivatives(y);
  return {d, distance_from(std::abs(d.g), d, growth_), std::max(margin_of(bounds_, y), -length_)};
}

// Motion sideways until a crossing or a touch has moved to the edge. At grazing incidence that is
// less than the way: as much as g changes on it, which is at least `rise`.
double RoomFinder::to_edge(const Place& at, double rise) const {
  return std::min(std::abs(at.margin), distance_from(std::abs(at.d.g) + rise, at.d, growth_));
}

// Half the slope is left in the middle between a crossing and where the segment would touch.
double RoomFinder::slope_rise(const Place& at) const {
  return 0.5 * std::abs(at.margin * at.d.gradient.dot(along_));
}

// A distance c that places in [lo, hi] of the segment have to move: one at t moves by 1 − t of
// what the beginning does and by t of what the end does.
RoomUse RoomFinder::use_of(double c, double lo, double hi) const {
  const double rate = 1.0 / std::max(c, 1e-300);
  lo = std::max(lo, 0.0);
  hi = std::min(hi, 1.0);
  if (segment_.end_moves) return {(1.0 - lo) * rate, hi * rate};
  return {beam_ ? rate : (1.0 - lo) * rate, 0.0};
}

// The surface, or its aperture's edge, comes to places in [lo, hi] no sooner than this.
void RoomFinder::meet(const Place& at, double rise, double lo, double hi) {
  const double c = at.margin > 0.0 ? std::max(at.distance, to_edge(at, rise)) : at.distance;
  free_ = either(free_, use_of(c, lo, hi));
}

// Those on the surface itself have nothing to move to.
void RoomFinder::look_at_ends(bool own, bool target) {
  const Place end = place(1.0);
  if (!segment_.end_moves) {
    // A light does not cross the surface, but near it the segment may come to touch: not before it
    // has turned about the light into the surface's tangent plane there.
    Place light = end;
    const double sine = std::abs(end.d.gradient.dot(along_)) / end.d.gradient.norm();
    light.distance = std::max(end.distance, length_ * sine);
    meet(light, slope_rise(light), 0.0, 1.0);
  } else if (!target) {
    meet(end, slope_rise(end), still_.empty() ? 0.0 : still_.back(), 1.0);
  }
  if (!target) ends_ = use_of(end.distance, 1.0, 1.0);
  if (own) return;
  const Place origin = place(0.0);
  ends_ = either(ends_, use_of(origin.distance, 0.0, 0.0));
  meet(origin, slope_rise(origin), 0.0, still_.empty() ? 1.0 : still_.front());
}

// Only where |g| has a minimum does the segment come near without crossing; it is no smaller up to
// the neighbours.
void RoomFinder::look_at_touches() {
  for (std::size_t i = 0; i < still_.size(); ++i) {
    const Place at = place(still_[i]);
    const double bend = along_.dot(at.d.hessian * along_);
    if (!(at.d.g * bend > 0.0)) continue;
    meet(at, 0.5 * at.margin * at.margin * std::abs(bend), i > 0 ? still_[i - 1] : 0.0,
         i + 1 < still_.size() ? still_[i + 1] : 1.0);
  }
}

void RoomFinder::look_at(double crossing) {
  const Place at = place(crossing);
  const double slide = std::abs(at.margin) / length_;
  const RoomUse edge = use_of(to_edge(at, slope_rise(at)), crossing - slide, crossing + slide);
  if (at.margin > 0.0) {
    free_ = either(free_, edge);
  } else if (crossing < segment_.end) {
    hidden_ = true;
    const RoomUse out = until_free(crossing, edge);
    if (out.total() < depth_.total()) depth_ = out;
  }
}

// Free again once the crossing leaves the aperture, meets a neighbour or passes an end.
RoomUse RoomFinder::until_free(double crossing, const RoomUse& edge) const {
  RoomUse out = either(ends_, edge);
  const auto meets_at = [&](double t) { out = either(out, use_of(place(t).distance, t, t)); };
  const auto next = std::lower_bound(still_.begin(), still_.end(), crossing);
  if (next != still_.end()) meets_at(*next);
  if (next != still_.begin()) meets_at(*std::prev(next));
  return out;
}

}  // namespace

RoomUse either(const RoomUse& a, const RoomUse& b) {
  return {std::max(a.by_begin, b.by_begin), std::max(a.by_end, b.by_end)};
}

double margin_of(const std::vector<geometry::Bound>& bounds, const Point& x) {
  double worst = -geometry::kInfinity;
  for (const auto& bound : bounds) worst = std::max(worst, bound.distance(x));
  return worst;
}

Room room_before(const SystemSurface& surface, int index, const Segment& segment, bool beam,
                 const geometry::RayParameters& crossings) {
  RoomFinder finder(surface, segment, beam);
  finder.look_at_ends(index == segment.own, index == segment.target);
  finder.look_at_touches();
  for (const double t : crossings) {
    if (t > segment.begin) finder.look_at(t);
  }
  return finder.found();
}

}  // namespace caustic::solver
