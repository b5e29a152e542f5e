// The pieces between the cuts of boundary curves, with the totals on both sides (S53).
#pragma once

#include <vector>

#include "solver/boundary_cuts.h"

namespace caustic::solver {

/// Of several sheets that end along one curve one that is not the curve's own: its mate's
/// (shared_edges.h), or that of another curve with the same image (S84).
struct Companion {
  Branch sheet;
  bool inside = true;  ///< on the side of the curve's own sheets
};

/// A place with all sheets but those that end there: the curve's own, or a pair of them, and its
/// companions.
struct BoundaryVertex {
  BoundaryPlace at;
  Branches others;
  std::vector<Companion> companions;  ///< the mate, if the curve has one, first
  double outside = 0.0;  ///< total without the sheets that end here, W/m²; ∞ where it is unbounded
  double inside = 0.0;   ///< total with them
  bool followed = true;  ///< false next to a caustic, where `others` is empty and totals unbounded
};

/// To another place of the curve; the mate is left to `place_mate`. False leaves sheets behind.
bool carry_beside(SheetCarrier& carrier, const BoundaryCurve& curve, Branches& others,
                  std::vector<Companion>& companions, const Vec2& to);
/// Of a curve that has a mate.
void place_mate(SheetCarrier& carrier, const BoundaryCurve& curve, const FieldPoint& own,
                std::vector<Companion>& companions);
/// Fills in the mate and both totals.
void complete_totals(SheetCarrier& carrier, const BoundaryCurve& curve, BoundaryVertex& v);
/// All sheets of one side, not of a caustic's inside.
Branches branches_on(const BoundaryCurve& curve, const BoundaryVertex& v, bool inside);

/// Runs with the inside, where its sheets are, on the left (u right, v up).
struct BoundaryPiece {
  int curve;
  bool closed = false;
  std::vector<BoundaryVertex> vertices;
};

struct BoundaryPieces {
  std::vector<BoundaryPiece> pieces;
  std::size_t unresolved = 0;  ///< pieces whose totals could not be followed
};

/// Leaves out what is no boundary because the sheets that would begin there are hidden.
BoundaryPieces cut_boundaries(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves,
                              double chord, Budget& budget);

}  // namespace caustic::solver
