#include "solver/clear_way.h"

#include <algorithm>

#include "solver/enclosed_graph.h"

namespace caustic::solver {

using geometry::Interval;
using geometry::IntervalVec3;

namespace {

// Ways are halved so often before they are given up; beams come from far.
constexpr int kWayHalvings = 12;
// And so often to find where they pass through a surface.
constexpr int kCrossingHalvings = 6;

bool apart(const IntervalVec3& a, const geometry::Box& b) {
  for (int i = 0; i < 3; ++i) {
    const Interval& w = a[static_cast<std::size_t>(i)];
    if (w.hi < b.min[i] || w.lo > b.max[i]) return true;
  }
  return false;
}

// One of the bounds keeps the surface out of the box.
bool cut_away(const SystemSurface& surface, const IntervalVec3& box) {
  const geometry::Box inside = geometry::box_of(box);
  return std::any_of(surface.bounds.begin(), surface.bounds.end(),
                     [&](const geometry::Bound& b) { return b.least_in(inside) > 0.0; });
}

// None of the bounds cuts the surface in the box.
bool whole_in(const SystemSurface& surface, const IntervalVec3& box) {
  const geometry::Box inside = geometry::box_of(box);
  return std::all_of(surface.bounds.begin(), surface.bounds.end(),
                     [&](const geometry::Bound& b) { return b.largest_in(inside) <= 0.0; });
}

}  // namespace

ClearWay::ClearWay(const ForwardMap& map) : map_(map) {}

// Where the lines are at these shares of their length.
IntervalVec3 ClearWay::Way::over(const Interval& part) const {
  IntervalVec3 box;
  for (std::size_t i = 0; i < 3; ++i)
    box[i] = meet(to[i] - (Interval(1.0) - part) * along[i], from[i] + part * along[i]);
  return box;
}

// (S83): g has no zero on the part of the way, or none but the one at its end on the surface.
bool ClearWay::misses(const SystemSurface& blocker, const Way& way, const Interval& part,
                      int halvings) const {
  const IntervalVec3 box = way.over(part);
  if (apart(box, blocker.region)) return true;
  const auto over = blocker.shape->enclose(box);
  if (!over.g.contains_zero() || cut_away(blocker, box)) return true;
  if (&blocker == &map_.mirror() && part.lo == 0.0) {
    const Interval slope = over.gradient[0] * way.direction[0] +
                           over.gradient[1] * way.direction[1] +
                           over.gradient[2] * way.direction[2];
    if (!slope.contains_zero()) return true;
  }
  if (halvings == 0) return false;
  const double middle = part.middle();
  return misses(blocker, way, {part.lo, middle}, halvings - 1) &&
         misses(blocker, way, {middle, part.hi}, halvings - 1);
}

// A line from a convex body's surface meets it nowhere else if it begins outwards or ends inside.
bool ClearWay::leaves_mirror(const Way& way) const {
  const auto& shape = map_.shape();
  return shape.convex(way.side) ||
         (shape.convex(-way.side) && (-double(way.side) * shape.enclose(way.to).g).hi <= 0.0);
}

// g has both signs on every line, and its zero in between is on the surface.
bool ClearWay::crosses(const SystemSurface& blocker, const Way& way, const Interval& part,
                       int sign_before, int sign_behind, int halvings) const {
  const IntervalVec3 box = way.over(part);
  if (sign_before * sign_behind < 0 && whole_in(blocker, box)) return true;
  if (halvings == 0 || apart(box, blocker.region) || cut_away(blocker, box)) return false;
  const double middle = part.middle();
  const int sign = sign_of(blocker.shape->enclose(way.over(middle)).g);
  return crosses(blocker, way, {part.lo, middle}, sign_before, sign, halvings - 1) ||
         crosses(blocker, way, {middle, part.hi}, sign, sign_behind, halvings - 1);
}

Passage ClearWay::passage(const Way& way) const {
  Passage all = Passage::clear;
  for (const SystemSurface& blocker : map_.system().surfaces()) {
    const bool own = &blocker == &map_.mirror();
    if ((own && leaves_mirror(way)) || misses(blocker, way, {0.0, 1.0}, kWayHalvings)) continue;
    const int before = own ? 0 : sign_of(blocker.shape->enclose(way.from).g);
    const int behind = sign_of(blocker.shape->enclose(way.to).g);
    if (crosses(blocker, way, {0.0, 1.0}, before, behind, kCrossingHalvings))
      return Passage::hidden;
    all = Passage::unknown;
  }
  return all;
}

Passage ClearWay::passage(const IntervalVec3& x, const IntervalVec3& image,
                          const IntervalVec3& leaving) const {
  Way to_light{x, x, x, x, map_.side()};
  if (const auto* lamp = std::get_if<PointLight>(&map_.system().light())) {
    to_light.to = geometry::intervals(lamp->position);
    for (std::size_t i = 0; i < 3; ++i) to_light.along[i] = to_light.to[i] - x[i];
  } else {
    double far = 0.0;
    const Point at(x[0].middle(), x[1].middle(), x[2].middle());
    for (const SystemSurface& s : map_.system().surfaces()) {
      far = std::max(far, (s.region.center() - at).norm() + s.region.diagonal());
    }
    const Vec3 d = -far * std::get<CollimatedLight>(map_.system().light()).direction;
    to_light.along = geometry::intervals(d);
    for (std::size_t i = 0; i < 3; ++i) to_light.to[i] = x[i] + to_light.along[i];
  }
  to_light.direction = to_light.along;
  const bool reflects = map_.mirror().optics.kind == Optics::Kind::mirror;
  Way onward{x, image, x, leaving, reflects ? map_.side() : -map_.side()};
  for (std::size_t i = 0; i < 3; ++i) onward.along[i] = image[i] - x[i];
  const Passage before = passage(to_light);
  if (before == Passage::hidden) return before;
  const Passage behind = passage(onward);
  return before == Passage::clear || behind == Passage::hidden ? behind : before;
}

}  // namespace caustic::solver
