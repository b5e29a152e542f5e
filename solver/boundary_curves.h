// The curves on the receiver across which the number of sheets changes: images of caustics and of
// the boundaries of families, traced by the code that traces levels, and the edges of the receiver
// (S51).
#pragma once

#include <vector>

#include "solver/branches.h"

namespace caustic::solver {

struct BoundaryCurve {
  BoundaryKind kind;
  int field = -1;       ///< −1 for the receiver's edges
  int boundary = -1;    ///< of the field's domain; −1 for caustics and the receiver's edges
  bool closed = false;  ///< then the first vertex is not repeated
  std::vector<Vec2> q;  ///< vertices, receiver axes, m
  std::vector<FieldPoint> own;  ///< the sheet's points; empty for the receiver's edges

  bool on_receiver_edge() const { return kind == BoundaryKind::receiver; }
  LevelFunction function(const FamilyField& f) const {
    return boundary < 0 ? LevelFunction::caustic() : LevelFunction::boundary_of(f.domain, boundary);
  }
};

/// Polylines within `chord` (m) of the curves, complete as far as the exploration of the fields is.
/// The receiver's four edges come last, counterclockwise.
std::vector<BoundaryCurve> trace_boundaries(SheetCarrier& carrier, Budget& budget, double chord,
                                            double residual);

}  // namespace caustic::solver
