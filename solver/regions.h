// The faces between the boundaries of all sheets, in each of which the same sheets arrive
// everywhere. NOTATION.md (S67).
#pragma once

#include <vector>

#include "solver/boundary_pieces.h"
#include "solver/contours.h"

namespace caustic::solver {

struct Regions {
  std::vector<Region> regions;  ///< by (u, v)
  std::size_t unresolved = 0;   ///< faces that could not be closed, or whose sheets contradict
};

/// Of faces whose width and height are both above `largest`, m, nothing is said.
Regions find_regions(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves,
                     const std::vector<BoundaryPiece>& pieces,
                     double largest = geometry::kInfinity);

}  // namespace caustic::solver
