// The vertices of a boundary piece from one of them on, with all sheets carried along, up to its
// end or to where one of them ends that no cut tells of (S53), (S87).
#pragma once

#include <optional>
#include <vector>

#include "solver/boundary_pieces.h"

namespace caustic::solver {

struct FollowedPiece {
  std::vector<BoundaryVertex> vertices;  ///< without the first
  std::vector<BoundaryPlace> rest;       ///< what lies beyond where a sheet ended, if one did
  bool lost = false;                     ///< true if it could neither be followed nor parted
};

class PieceFollower {
 public:
  PieceFollower(SheetCarrier& carrier, const BoundaryCurve& curve)
      : carrier_(carrier), curve_(curve), width_(carrier.system().receiver().width()) {}

  FollowedPiece follow(const BoundaryVertex& first, const std::vector<BoundaryPlace>& places);

 private:
  bool carry(BoundaryVertex& v);
  bool varies_little(const BoundaryVertex& a, const BoundaryVertex& b, bool inside) const;
  bool reach(const BoundaryVertex& from, const BoundaryPlace& to, int depth,
             std::vector<BoundaryVertex>& out);
  std::optional<BoundaryVertex> approach(BoundaryVertex from);

  SheetCarrier& carrier_;
  const BoundaryCurve& curve_;
  double width_;
  BoundaryPlace stuck_;  // the last that could not be reached
};

}  // namespace caustic::solver
