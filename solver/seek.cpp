#include "solver/seek.h"

#include <algorithm>

namespace caustic::solver {

namespace {

using geometry::Point;
using geometry::Vec3;

// Between a cell's rays the way they pass changes by this share of what it does among them and the
// middle one.
constexpr double kSpreadReach = 1.5;
// Rays this share of the surface's radius apart do not pass on both sides of it.
constexpr double kDenseShare = 0.25;

// From the place of the ray that comes nearest to the middle c to that.
Vec3 away(const NearMiss& ray, const Point& c) {
  const Vec3 to_c = c - ray.o;
  return to_c - std::max(to_c.dot(ray.w) / ray.w.squaredNorm(), 0.0) * ray.w;
}

}  // namespace

Between between(std::span<const NearMiss> rays, const NearMiss& middle,
                const geometry::Box& region) {
  const Point c = region.center();
  const Vec3 through = away(middle, c);
  double spread = 0.0;
  for (const NearMiss& ray : rays) {
    if (ray.hop < 0 || ray.hop != middle.hop) return Between::mixed;
    spread = std::max(spread, (away(ray, c) - through).norm());
  }
  // A long strip is as small as it is wide.
  Vec3 extent = region.max - region.min;
  std::sort(extent.begin(), extent.end());
  if (!(spread > kDenseShare * 0.5 * extent[1])) return Between::dense;
  const double far = (c - middle.o).norm() + region.diagonal();
  const geometry::Ray segment{middle.o, (far / middle.w.norm()) * middle.w};
  return region.may_meet(segment, kSpreadReach * spread) ? Between::perhaps : Between::nothing;
}

}  // namespace caustic::solver
