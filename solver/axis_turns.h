// Where an arc could turn back: the edges between rectangles in which totals are monotone along
// different axes. NOTATION.md (S79).
#pragma once

#include <array>
#include <vector>

#include "solver/mirror_cells.h"
#include "solver/rectangle_totals.h"

namespace caustic::solver {

/// A rectangle and, by level, the axes along which each of its totals that may have the level is
/// monotone; none where the level is not there.
struct MonotonePart {
  ReceiverCell part;
  std::vector<Axes> axes;
};

/// A piece of an edge of a rectangle, along an axis of that rectangle.
struct AxisTurn {
  int rectangle;  ///< index
  int level;
  Vec2 from, to;

  using Key = std::array<double, 5>;
  Key key() const { return {from.x(), from.y(), to.x(), to.y(), double(level)}; }
};

/// An arc that is closed and within the parts crosses one of these. Parts that touch do so along
/// edges with exactly the same coordinate.
std::vector<AxisTurn> axis_turns(const std::vector<MonotonePart>& parts);

}  // namespace caustic::solver
