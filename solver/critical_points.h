// Places on the receiver where the gradient of a sheet's irradiance, or of the total, vanishes:
// maxima, minima and saddles inside of faces. NOTATION.md (S66).
#pragma once

#include <optional>
#include <vector>

#include "solver/branches.h"
#include "solver/contours.h"

namespace caustic::solver {

/// ∇∇E of the sum, by central differences of its gradient in closed form along carried sheets;
/// nothing where they cannot be carried that far.
std::optional<geometry::Mat2> hessian_of_total(SheetCarrier& carrier, const Vec2& q,
                                               const Branches& at);

/// Carrying does not ask where a sheet ends: false if one of these has been carried beyond.
bool sheets_exist(const SheetCarrier& carrier, const Branches& branches);

/// A critical point with its sheets.
struct SettledPoint {
  Vec2 q;
  Branches branches;
  Total total;
  CriticalType type;
};

/// The critical point of the sum of these sheets to which Newton's method leads from a place with
/// them, no farther than `roam` (m); nothing if it leads nowhere, beyond the receiver or a sheet's
/// end, or to where E has no curvature in some direction.
std::optional<SettledPoint> settle(SheetCarrier& carrier, const Vec2& q, const Branches& branches,
                                   double roam);

/// Critical points of the total: from a grid over the receiver, from those of sheets and from
/// `places`. As complete as these starts are.
std::vector<CriticalPlace> critical_points_of_total(SheetCarrier& carrier,
                                                    const std::vector<Vec2>& places);

/// Those of each sheet by itself, of all of the carrier's fields: as complete as exploration is.
std::vector<CriticalPlace> critical_points_of_sheets(SheetCarrier& carrier);

}  // namespace caustic::solver
