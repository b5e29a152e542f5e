// Where the total passes a level on one side of a boundary piece, and where the level lies between
// the totals on both sides (S53).
#pragma once

#include <array>
#include <vector>

#include "solver/boundary_pieces.h"

namespace caustic::solver {

/// |E_tot/E₀ − 1| that rounding may leave where light grazes or comes from next to its surface:
/// what Newton's method or a bracket ends with that is more is no place of the level (S85).
constexpr double kLevelNoise = 1e-6;

/// A level arc begins or ends here, on one side of a boundary.
struct TotalNode {
  Vec2 q;
  Branches branches;  ///< of that side
  Vec2 into;          ///< direction on the receiver into that side
};

/// A part of a boundary piece, inside on the left.
struct JumpArc {
  BoundaryKind kind;
  int curve;  ///< index of its boundary curve
  bool closed = false;
  std::vector<BoundaryVertex> vertices;
  bool turned = false;  ///< of a jump: the brighter side is the outside, where companions are
};

struct LevelOnBoundaries {
  std::vector<TotalNode> nodes;
  std::vector<JumpArc> jumps;   ///< the level lies between the totals on both sides
  std::vector<JumpArc> within;  ///< both totals are above it
};

LevelOnBoundaries level_on_boundaries(SheetCarrier& carrier,
                                      const std::vector<BoundaryCurve>& curves,
                                      const std::vector<BoundaryPiece>& pieces, double level,
                                      double residual);

}  // namespace caustic::solver
