// A chart maps the unit square onto a part of a surface. Exploration subdivides the square; points
// lie on the surface to rounding.
#pragma once

#include <functional>

#include "geometry/linear.h"

namespace caustic::geometry {

struct Chart {
  /// (s, t) in [0,1]² → a point of the surface.
  std::function<Point(double s, double t)> point;
};

}  // namespace caustic::geometry
