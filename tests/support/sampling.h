// Random points on a surface.
#pragma once

#include <vector>

#include "geometry/surface.h"
#include "tests/support/random.h"

namespace caustic::test {

/// A box of half size `half` about `center`, resolved to half/3.
inline geometry::Extent extent_about(const geometry::Point& center, double half) {
  return {geometry::Box::around(center, half), center, half / 3.0};
}

/// `n` points through the charts, inside the extent's region and the shape's own bounds.
inline std::vector<geometry::Point> sample_surface(const geometry::Surface& surface,
                                                   const geometry::Extent& extent, int n,
                                                   Random& random) {
  const auto charts = surface.charts(extent);
  const auto bounds = surface.own_bounds();
  std::vector<geometry::Point> points;
  for (int tries = 0; static_cast<int>(points.size()) < n && tries < 1000 * n; ++tries) {
    const auto& chart = charts[random.index(static_cast<int>(charts.size()))];
    const double s = random.uniform(), t = random.uniform();
    const geometry::Point x = chart.point(s, t);
    if (!geometry::exists_at(chart.cell, x)) continue;
    if (extent.region.contains(x) && geometry::exists_at(bounds, x)) points.push_back(x);
  }
  return points;
}

}  // namespace caustic::test
