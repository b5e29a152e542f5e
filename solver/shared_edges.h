// Curves along which sheets of two families begin at once: what hides a ray on one side of such a
// curve sends it on, by another family, from the other. They are one boundary, never two (S81).
#pragma once

#include <optional>
#include <vector>

#include "solver/boundary_curves.h"

namespace caustic::solver {

/// Of a hidden edge: the field of the family whose own sheets begin there too, or −1.
int mate_along(SheetCarrier& carrier, const BoundaryCurve& curve);

/// Where that sheet begins, next to a place of the curve that has one.
struct Mate {
  Branch sheet;
  Vec3 inside;  ///< direction along its first surface to where it is
};
Mate mate_at(SheetCarrier& carrier, const BoundaryCurve& curve, const FieldPoint& own);

/// Places on the first surface of a field's family next to which boundaries of others say that
/// something begins to hide it.
std::vector<Point> places_by_mates(SheetCarrier& carrier, int field,
                                   const std::vector<BoundaryCurve>& curves);

/// Gives hidden edges their mates, and takes the same curves, as boundaries of the mate's family,
/// out. `chord` is what the polylines were traced with, m.
void merge_shared_edges(SheetCarrier& carrier, std::vector<BoundaryCurve>& curves, double chord);

}  // namespace caustic::solver
