// A surface as graphs of one coordinate over the other two, in boxes that are proven to hold all of
// it (S70): charts that need nothing but the ranges of g and ∇g.
#pragma once

#include <functional>
#include <vector>

#include "geometry/surface.h"

namespace caustic::geometry {

/// The part of the surface in the box `own`. Over each place of own's rectangle across `axis` there
/// is at most one point of the surface with its coordinate along `axis` in `reach`.
struct GraphChart {
  int axis;
  IntervalVec3 own;
  Interval reach;  ///< wider than own[axis], so that a graph goes on where it leaves `own`

  /// The chart's coordinates (s, t); (first, second, axis) is a cyclic order.
  std::size_t along() const { return static_cast<std::size_t>(axis); }
  std::size_t first() const { return static_cast<std::size_t>((axis + 1) % 3); }
  std::size_t second() const { return static_cast<std::size_t>((axis + 2) % 3); }
};

struct GraphCover {
  std::vector<GraphChart> charts;
  /// Boxes given up: ∇g vanishes there, or nearly; or they were to be divided when told to stop.
  std::vector<Box> undecided;
};

/// All points of the surface in `region` that `bounds` admit lie in one of the boxes. `stop` is
/// asked before each box is looked at.
GraphCover cover_by_graphs(const Surface& surface, const std::vector<Bound>& bounds,
                           const Box& region, const std::function<bool()>& stop = {});

}  // namespace caustic::geometry
