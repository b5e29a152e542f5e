// The point of a polygon with holes that is farthest from its edges.
#pragma once

#include <vector>

#include "geometry/linear.h"

namespace caustic::solver {

struct DeepestPoint {
  geometry::Vec2 at;
  double depth;  ///< distance from the nearest edge; ≤ 0 if no point inside has been found
};

/// `rings` are closed polylines, first points not repeated; inside is what an odd number of them
/// surrounds. The depth is within `precision` of the largest one.
DeepestPoint deepest_point(const std::vector<std::vector<geometry::Vec2>>& rings, double precision);

/// Twice its signed area, positive if it runs counterclockwise.
double twice_area(const std::vector<geometry::Vec2>& ring);
/// By the parity of the edges above it.
bool surrounds(const std::vector<geometry::Vec2>& ring, const geometry::Vec2& q);

}  // namespace caustic::solver
