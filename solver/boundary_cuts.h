// Where boundary curves have to be cut so that along each piece the number of sheets on either side
// is constant: crossings of images, folds, contacts with the caustic, corners (S52), (S57).
#pragma once

#include <optional>
#include <vector>

#include "solver/boundary_curves.h"

namespace caustic::solver {

/// A place on a boundary curve.
struct BoundaryPlace {
  Vec2 q;
  FieldPoint own;  ///< meaningless on the receiver's edges
};

/// The place on the curve next to a place near it.
std::optional<BoundaryPlace> settle_on(SheetCarrier& carrier, const BoundaryCurve& curve,
                                       const BoundaryPlace& near);
/// A place near the curve at share w of its segment i.
BoundaryPlace on_segment(const BoundaryCurve& curve, std::size_t i, double w);

/// Velocity of the image for the unit tangent `t` of the curve on its first surface, which is
/// returned too; of the receiver's edges a unit vector, and t = 0. Zero at cusps.
Vec2 image_tangent(const SheetCarrier& carrier, const BoundaryCurve& curve, const BoundaryPlace& at,
                   Vec3& t);

/// Places nearer than this share of the receiver's width are one cut.
constexpr double kSameCut = 1e-9;

struct Cut {
  double at;  ///< index of a vertex and share of the way to the next
  BoundaryPlace place;
};

/// For each curve, along it. `chord` is what the polylines were traced with, m.
std::vector<std::vector<Cut>> find_cuts(SheetCarrier& carrier,
                                        const std::vector<BoundaryCurve>& curves, double chord,
                                        Budget& budget);

}  // namespace caustic::solver
