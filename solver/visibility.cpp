#include "solver/visibility.h"

#include <algorithm>
#include <cmath>

namespace caustic::solver {

using geometry::Ray;
using geometry::RayParameters;

namespace {

// A light or a receiver that touches a surface is not hidden by it: crossings this close to the far
// end of a segment, as a share of it, do not block.
constexpr double kLightEndShare = 1e-9;
constexpr double kReceiverEndShare = 1e-12;
// The crossing at the segment's own beginning is looked for within this share of it, and within so
// many roundings of its place.
constexpr double kOwnShare = 1e-7;
constexpr double kOwnRoundings = 1e3;

// Distance from the aperture's edge, < 0 inside.
double margin_of(const std::vector<geometry::Bound>& bounds, const Point& x) {
  double worst = -geometry::kInfinity;
  for (const auto& bound : bounds) worst = std::max(worst, bound.distance(x));
  return worst;
}

// Least distance at which a function of this size may vanish that changes as g does, to second
// order: |g| <= |∇g| δ + ½ |H| δ² solved for δ. A first-order distance is too large inside of
// curved surfaces.
double distance_from(double g, const geometry::SurfaceDerivatives& d, double growth) {
  const double slope = d.gradient.norm();
  return 2.0 * g / (slope + std::sqrt(slope * slope + 2.0 * growth * g * d.hessian.norm()));
}
// How much larger the Hessian may be on the way than where it is asked; it is constant for
// quadrics.
constexpr double kHessianGrowth = 6.0;

}  // namespace

Visibility::Visibility(const OpticalSystem& system, const geometry::EmbreeScene* candidates,
                       double margin)
    : system_(system), candidates_(candidates), margin_(margin) {}

LightPath::LightPath(const ForwardMap& map, const Point& x, const Hit* hits, const Point& p)
    : count(map.hop_count() + 1) {
  at[0] = x;
  for (int j = 1; j < count - 1; ++j) at[j] = hits[j].y;
  at[count - 1] = p;
}

double Sight::used(const LightPath& from, const LightPath& to) const {
  double most = 0.0, before = 0.0;
  for (int j = 0; j < from.count; ++j) {
    const double moved = (to.at[j] - from.at[j]).norm();
    most = std::max(most, use[j].by_begin * before + use[j].by_end * moved);
    before = moved;
  }
  return most;
}

namespace {

Sight::Use either(const Sight::Use& a, const Sight::Use& b) {
  return {std::max(a.by_begin, b.by_begin), std::max(a.by_end, b.by_end)};
}

double total(const Sight::Use& use) { return use.by_begin + use.by_end; }

}  // namespace

// From the light to the first surface, looked at the other way; then as light goes.
Visibility::Way Visibility::way(const Hops& hops, const LightPath& path) const {
  const int first = hops.empty() ? -1 : hops[0].surface;
  Segment to_light{{path.x(), Vec3::Zero()}, 1.0 - kLightEndShare, false, first};
  if (hops.empty()) to_light.begin = kReceiverEndShare;
  if (const auto* point = std::get_if<PointLight>(&system_.light())) {
    to_light.ray.direction = point->position - path.x();
  } else {
    // Far enough to have passed every surface.
    double reach = 0.0;
    for (const auto& s : system_.surfaces()) {
      reach = std::max(reach, (s.region.center() - path.x()).norm() + s.region.diagonal());
    }
    to_light.ray.direction = -reach * std::get<CollimatedLight>(system_.light()).direction;
  }
  Way way{{to_light}, 1};
  for (std::size_t j = 0; j < hops.size(); ++j) {
    const bool last = j + 1 == hops.size();
    way.segments[way.count++] = {{path.at[j], path.at[j + 1] - path.at[j]},
                                 1.0 - kReceiverEndShare,
                                 true,
                                 hops[j].surface,
                                 last ? -1 : hops[j + 1].surface};
  }
  return way;
}

Sight Visibility::look(const Hops& hops, const LightPath& path) const {
  const Way light = way(hops, path);
  const Room lit = room(light.segments[0]);
  Sight sight{lit.hidden, Ending::shadow, {}};
  sight.use[0].by_end = lit.use.by_begin;  // that segment was looked along the other way
  double least = total(lit.use);
  // Hidden for as long as one segment is: the one that is so the furthest.
  for (int j = 1; j < light.count; ++j) {
    const Room seen = room(light.segments[j]);
    if (seen.hidden && !sight.hidden) {
      sight = {true, Ending::occlusion, {}};
      least = geometry::kInfinity;
    }
    if (sight.hidden && !(seen.hidden && total(seen.use) < least)) continue;
    if (sight.hidden) {
      sight.use = {};
      least = total(seen.use);
    }
    sight.use[j] = seen.use;
  }
  return sight;
}

std::vector<Visibility::Meeting> Visibility::meetings(const Hops& hops,
                                                      const LightPath& path) const {
  std::vector<Meeting> all;
  const Way light = way(hops, path);
  RayParameters roots;
  for (int j = 0; j < light.count; ++j) {
    const Segment& segment = light.segments[j];
    for (int i = 0; i < static_cast<int>(system_.surfaces().size()); ++i) {
      roots.clear();
      if (!free_of_own(segment, i)) crossings(segment, i, roots);
      for (const double t : roots) {
        if (!(t > segment.begin && t < segment.end)) continue;
        const Point y = segment.ray.at(t);
        all.push_back({j, i, y, margin_of(system_.surfaces()[i].bounds, y)});
      }
    }
  }
  return all;
}

// Inside a convex surface the way from it to the light is free.
bool Visibility::free_of_own(const Segment& segment, int surface) const {
  if (surface != segment.own || segment.end_moves) return false;
  const auto& shape = *system_.surfaces()[surface].shape;
  return shape.convex(shape.value(segment.ray.at(1.0)) < 0.0 ? 1 : -1);
}

// All but the one crossing where the segment begins, or ends, which is not in its way.
void Visibility::crossings(const Segment& segment, int index, RayParameters& roots) const {
  const Ray& ray = segment.ray;
  const bool own = index == segment.own, target = index == segment.target;
  const double near = kOwnShare + kOwnRoundings * geometry::kEpsilon *
                                      (ray.origin.cwiseAbs().maxCoeff() + system_.diameter()) /
                                      ray.direction.norm();
  system_.surfaces()[index].shape->crossings(ray, own ? -near : 0.0, target ? 1.0 + near : 1.0,
                                             roots);
  const auto erase_at = [&](double t) {
    const auto nearest = std::min_element(roots.begin(), roots.end(), [t](double a, double b) {
      return std::abs(a - t) < std::abs(b - t);
    });
    if (nearest != roots.end() && std::abs(*nearest - t) <= near) roots.erase(nearest);
  };
  if (own) erase_at(0.0);
  if (target) erase_at(1.0);
}

Visibility::Room Visibility::room(const Segment& segment) const {
  Sight::Use free, depth{geometry::kInfinity, geometry::kInfinity};
  bool hidden = false;
  // Free of all surfaces, or hidden as long as it is by one of them.
  const auto ask = [&](int surface) {
    const Room r = room(segment, surface);
    hidden |= r.hidden;
    if (!r.hidden)
      free = either(free, r.use);
    else if (total(r.use) < total(depth))
      depth = r.use;
  };
  if (candidates_) {
    thread_local std::vector<int> found;
    found.clear();
    candidates_->candidates(segment.ray, 1.0, found);
    for (const int surface : found) ask(surface);
    free = either(free, {1.0 / margin_, 1.0 / margin_});
  } else {
    for (int i = 0; i < static_cast<int>(system_.surfaces().size()); ++i) ask(i);
  }
  return hidden ? Room{true, depth} : Room{false, free};
}

Visibility::Room Visibility::room(const Segment& segment, int index) const {
  const auto& surface = system_.surfaces()[index];
  const auto& shape = surface.shape;
  const auto& bounds = surface.bounds;
  const auto& region = surface.region;
  const Ray& ray = segment.ray;
  const bool own = index == segment.own, target = index == segment.target;
  if (!own && !region.may_meet(ray, margin_)) return {false, {1.0 / margin_, 1.0 / margin_}};
  if (free_of_own(segment, index)) return {};
  thread_local RayParameters roots, still;
  roots.clear();
  still.clear();
  const double length = ray.direction.norm();
  crossings(segment, index, roots);
  shape->stationary(ray, 0.0, 1.0, still);

  // A place on the segment: how far the surface is, and how far the aperture's edge.
  struct Place {
    geometry::SurfaceDerivatives d;
    double distance, margin;
  };
  const double growth = shape->at_most_quadratic() ? 1.0 : kHessianGrowth;
  const auto place = [&](double t) {
    const Point y = ray.at(t);
    const auto d = shape->derivatives(y);
    return Place{d, distance_from(std::abs(d.g), d, growth),
                 std::max(margin_of(bounds, y), -length)};
  };
  // Motion sideways until a crossing or a touch has moved to the edge. At grazing incidence that is
  // less than the way: as much as g changes on it, which is at least `rise`.
  const Vec3 along = ray.direction / length;
  const auto to_edge = [&](const Place& at, double rise) {
    return std::min(std::abs(at.margin), distance_from(std::abs(at.d.g) + rise, at.d, growth));
  };
  // Half the slope is left in the middle between a crossing and where the segment would touch.
  const auto slope_rise = [&](const Place& at) {
    return 0.5 * std::abs(at.margin * at.d.gradient.dot(along));
  };
  // A distance c that places in [lo, hi] of the segment have to move: one at t moves by 1 − t of
  // what the beginning does and by t of what the end does.
  const bool turns = std::holds_alternative<PointLight>(system_.light());
  const auto use_of = [&](double c, double lo, double hi) -> Sight::Use {
    const double rate = 1.0 / std::max(c, 1e-300);
    lo = std::max(lo, 0.0);
    hi = std::min(hi, 1.0);
    if (segment.end_moves) return {(1.0 - lo) * rate, hi * rate};
    return {turns ? (1.0 - lo) * rate : rate, 0.0};
  };
  Sight::Use free, depth{geometry::kInfinity, geometry::kInfinity};
  bool hidden = false;
  const auto meet = [&](const Place& at, double rise, double lo, double hi) {
    const double c = at.margin > 0.0 ? std::max(at.distance, to_edge(at, rise)) : at.distance;
    free = either(free, use_of(c, lo, hi));
  };

  const Place end = place(1.0);
  const double first_still = still.empty() ? 1.0 : still.front();
  const double last_still = still.empty() ? 0.0 : still.back();
  Sight::Use ends;
  if (!segment.end_moves) {
    // A light does not cross the surface, but near it the segment may come to touch: not before it
    // has turned about the light into the surface's tangent plane there.
    Place light = end;
    const double sine = std::abs(end.d.gradient.dot(along)) / end.d.gradient.norm();
    light.distance = std::max(end.distance, length * sine);
    meet(light, slope_rise(light), 0.0, 1.0);
  } else if (!target) {
    meet(end, slope_rise(end), last_still, 1.0);
  }
  if (!target) ends = use_of(end.distance, 1.0, 1.0);
  if (!own) {
    const Place origin = place(0.0);
    ends = either(ends, use_of(origin.distance, 0.0, 0.0));
    meet(origin, slope_rise(origin), 0.0, first_still);
  }
  for (std::size_t i = 0; i < still.size(); ++i) {
    const Place at = place(still[i]);
    const double bend = along.dot(at.d.hessian * along);
    // Only where |g| has a minimum does the segment come near without crossing; it is no smaller up
    // to the neighbours.
    if (at.d.g * bend > 0.0) {
      meet(at, 0.5 * at.margin * at.margin * std::abs(bend), i > 0 ? still[i - 1] : 0.0,
           i + 1 < still.size() ? still[i + 1] : 1.0);
    }
  }
  for (const double t : roots) {
    if (t <= segment.begin) continue;
    const Place at = place(t);
    const double slide = std::abs(at.margin) / length;
    const Sight::Use edge = use_of(to_edge(at, slope_rise(at)), t - slide, t + slide);
    if (at.margin > 0.0) {
      free = either(free, edge);
    } else if (t < segment.end) {
      // Free again once the crossing leaves the aperture, meets a neighbour or passes an end.
      Sight::Use out = either(ends, edge);
      const auto next = std::lower_bound(still.begin(), still.end(), t);
      if (next != still.end()) out = either(out, use_of(place(*next).distance, *next, *next));
      if (next != still.begin()) {
        const double before = *std::prev(next);
        out = either(out, use_of(place(before).distance, before, before));
      }
      hidden = true;
      if (total(out) < total(depth)) depth = out;
    }
  }
  return hidden ? Room{true, depth} : Room{false, free};
}

bool Lookout::hidden(const LightPath& path) {
  for (const auto& [from, sight] : seen_) {
    if (sight.used(from, path) < kUsableRoom) return sight.hidden;
  }
  const Sight sight = visibility_.look(hops_, path);
  if (seen_.size() < kRemembered) {
    seen_.push_back({path, sight});
  } else {
    seen_[oldest_] = {path, sight};
    oldest_ = (oldest_ + 1) % kRemembered;
  }
  return sight.hidden;
}

}  // namespace caustic::solver
