// The least and the largest total on the receiver: where its gradient vanishes inside of faces,
// along boundaries on either side, at their ends (S64).
#pragma once

#include "solver/analysis.h"
#include "solver/arc_points.h"

namespace caustic::solver {

struct TotalExtremes {
  Extreme min, max;
};

/// As complete as a grid over the receiver and the critical points of sheets can tell inside of
/// faces, and the vertices of the pieces along them.
TotalExtremes find_extremes(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves,
                            const std::vector<BoundaryPiece>& pieces);

}  // namespace caustic::solver
