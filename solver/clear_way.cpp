#include "solver/clear_way.h"

#include <algorithm>

namespace caustic::solver {

using geometry::Interval;
using geometry::IntervalVec3;

namespace {

// Ways are halved so often before they are given up; beams come from far.
constexpr int kWayHalvings = 12;

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

}  // namespace

ClearWay::ClearWay(const ForwardMap& map) : map_(map) {}

// (S83): g has no zero on the part of the way, or none but the one at its end on the surface.
bool ClearWay::misses(const SystemSurface& blocker, const Way& way, const Interval& part,
                      int halvings) const {
  IntervalVec3 box;
  for (std::size_t i = 0; i < 3; ++i) {
    box[i] =
        meet(way.to[i] - (Interval(1.0) - part) * way.along[i], way.from[i] + part * way.along[i]);
  }
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

bool ClearWay::misses_all(const Way& way) const {
  const auto& surfaces = map_.system().surfaces();
  return std::all_of(surfaces.begin(), surfaces.end(), [&](const SystemSurface& blocker) {
    return misses(blocker, way, {0.0, 1.0}, kWayHalvings);
  });
}

bool ClearWay::shown(const IntervalVec3& x, const IntervalVec3& image,
                     const IntervalVec3& leaving) const {
  Way to_light{x, x, x, x};
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
  Way onward{x, image, x, leaving};
  for (std::size_t i = 0; i < 3; ++i) onward.along[i] = image[i] - x[i];
  return misses_all(to_light) && misses_all(onward);
}

}  // namespace caustic::solver
