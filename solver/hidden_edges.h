// The edges of what surfaces hide of one family's light, found from where exploration saw
// visibility change, and followed from corner to corner (S57).
#pragma once

#include <vector>

#include "solver/boundary_curves.h"

namespace caustic::solver {

/// Appends the edges to `curves`, which holds the caustics and the boundaries of the field's
/// domain; each from one vertex before it begins to bound what is seen to one after it ceases to.
/// The field must have a visibility; next to the places `likely` on its first surface it is looked
/// for what exploration may not have seen. Returns how many changes of visibility no surface's edge
/// explains.
std::size_t add_hidden_edges(SheetCarrier& carrier, int field, const std::vector<Point>& likely,
                             std::vector<BoundaryCurve>& curves, Budget& budget, double chord,
                             double residual);

}  // namespace caustic::solver
