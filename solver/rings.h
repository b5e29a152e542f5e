// Arcs joined head to tail to the rings that bound a region (S55).
#pragma once

#include <cstddef>
#include <vector>

#include "geometry/linear.h"

namespace caustic::solver {

/// Where a curve begins and ends, and which way; brighter side on the left.
struct RingArc {
  geometry::Vec2 begin, end;
  geometry::Vec2 leaves, arrives;  ///< unit tangents
  bool closed = false;
};

struct Rings {
  std::vector<int> id, order;  ///< of each arc; order from 0 along its ring
  std::size_t open = 0;        ///< rings that do not close
};

/// Ends within `near` of a beginning meet there; where several do, the arc that keeps the region to
/// the left goes on: the first clockwise from the one that arrives.
Rings join_rings(const std::vector<RingArc>& arcs, double near);

}  // namespace caustic::solver
