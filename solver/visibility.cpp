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

// From the light to the first surface, looked at the other way; then as light goes.
Visibility::Way Visibility::way(const Hops& hops, const LightPath& path) const {
  const int first = hops.empty() ? -1 : hops[0].surface;
  Segment to_light{{path.x(), Vec3::Zero()}, 1.0 - kLightEndShare, false, first};
  if (hops.empty()) to_light.begin = kReceiverEndShare;
  if (const auto* point = std::get_if<PointLight>(&system_.light())) {
    to_light.ray.direction = point->position - path.x();
  } else {
    to_light.ray.direction =
        -system_.reach(path.x()) * std::get<CollimatedLight>(system_.light()).direction;
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
  double least = lit.use.total();
  // Hidden for as long as one segment is: the one that is so the furthest.
  for (int j = 1; j < light.count; ++j) {
    const Room seen = room(light.segments[j]);
    if (seen.hidden && !sight.hidden) {
      sight = {true, Ending::occlusion, {}};
      least = geometry::kInfinity;
    }
    if (sight.hidden && !(seen.hidden && seen.use.total() < least)) continue;
    if (sight.hidden) {
      sight.use = {};
      least = seen.use.total();
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

Room Visibility::room(const Segment& segment) const {
  RoomUse free, depth{geometry::kInfinity, geometry::kInfinity};
  bool hidden = false;
  // Free of all surfaces, or hidden as long as it is by one of them.
  const auto ask = [&](int surface) {
    const Room r = room(segment, surface);
    hidden |= r.hidden;
    if (!r.hidden)
      free = either(free, r.use);
    else if (r.use.total() < depth.total())
      depth = r.use;
  };
  if (candidates_) {
    thread_local std::vector<int> found;
    found.clear();
    candidates_->candidates(segment.ray, 1.0, found);
    for (const int surface : found) ask(surface);
    free = either(free, room_beside(segment));
  } else {
    for (int i = 0; i < static_cast<int>(system_.surfaces().size()); ++i) ask(i);
  }
  return hidden ? Room{true, depth} : Room{false, free};
}

// Before surfaces whose boxes are further away than the margin. Beyond the box of all surfaces none
// is in the way, so the end counts only by what it moves the part that is within (S13).
RoomUse Visibility::room_beside(const Segment& segment) const {
  const double least = 1.0 / margin_;
  if (!system_.extent().may_meet(segment.ray, 0.0)) return {least, least};
  const auto [enter, leave] = system_.extent().span_of(segment.ray, margin_);
  return {least * (1.0 - enter), least * leave};
}

Room Visibility::room(const Segment& segment, int index) const {
  const auto& surface = system_.surfaces()[index];
  if (index != segment.own && !surface.region.may_meet(segment.ray, margin_))
    return {false, {1.0 / margin_, 1.0 / margin_}};
  if (free_of_own(segment, index)) return {};
  thread_local RayParameters roots;
  roots.clear();
  crossings(segment, index, roots);
  const bool beam = !std::holds_alternative<PointLight>(system_.light());
  return room_before(surface, index, segment, beam, roots);
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
