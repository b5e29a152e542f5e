// How small is the part of a surface that its aperture leaves? Exploration has to look that
// closely.
#pragma once

#include <vector>

#include "geometry/surface.h"

namespace caustic::geometry {

/// About the radius of the largest disc on the surface that all bounds admit, m: about the place of
/// the largest margin −max h that a climb along the surface finds from `starts`; at most `enough`,
/// where the search stops. Not positive if no start leads to a point that exists.
double opening_radius(const Surface& surface, const std::vector<Bound>& bounds,
                      const std::vector<Point>& starts, double enough);

}  // namespace caustic::geometry
