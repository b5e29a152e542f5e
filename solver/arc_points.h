// Exact points between the vertices of arcs and boundaries, with all their sheets (S62).
#pragma once

#include <optional>

#include "solver/total_arcs.h"

namespace caustic::solver {

/// A point of a segment as a function of its parameter in [0, 1].
struct ArcPoint {
  Vec2 q, dq;         ///< place on the receiver and its derivative
  Branches branches;  ///< of a boundary: all but its own
  std::optional<FieldPoint>
      own;                 ///< of a boundary but the receiver's edge: the end of its own sheet
  Vec3 dx = Vec3::Zero();  ///< derivative of own.x
  std::vector<Companion> companions;  ///< of a boundary
  double off = 0.0;                   ///< of a level arc: distance from it that is left, m
};

/// Between two vertices of a level arc; nothing if it could not be followed.
std::optional<ArcPoint> along_level(SheetCarrier& carrier, double level, const ArcVertex& a,
                                    const ArcVertex& b, double t);

/// Between two vertices of a boundary curve; towards one where other sheets end in a fold, the
/// parameter is the root of the distance.
std::optional<ArcPoint> along_boundary(SheetCarrier& carrier, const BoundaryCurve& curve,
                                       const BoundaryVertex& a, const BoundaryVertex& b, double t);

/// What rounding of x moves the total by, W/m² (S14).
double rounding_of_total(const SheetCarrier& carrier, const Branches& branches);

}  // namespace caustic::solver
