// Enclosures of a surface by mean values.
#pragma once

#include "geometry/surface.h"

namespace caustic::geometry {

struct NarrowedEnclosure {
  Interval g;
  IntervalVec3 gradient;
};
/// Ranges of g and ∇g over a box, by mean values about its middle where these are narrower than
/// what enclose() says (S17).
NarrowedEnclosure narrowed(const Surface& surface, const IntervalVec3& box);

}  // namespace caustic::geometry
