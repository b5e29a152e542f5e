// What a scene needs: the pieces of its families that have to be explored, whether anything can be
// hidden, whether Embree pays. What is left out is named, with the reason.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "solver/contours.h"

namespace caustic::solver {

/// One family on one lit side of its mirror.
struct PlannedPiece {
  int family;
  int surface;
  int side;          ///< s of NOTATION.md
  bool visibility;   ///< something may be hidden
};

struct Plan {
  std::vector<PlannedPiece> pieces;
  bool embree = false;
  std::vector<Skipped> skipped;
};

/// `families` are one-bounce families by surface index. Stages named in `no_skip` run in any case:
/// "dark_side", "visibility", "embree".
Plan make_plan(const OpticalSystem& system, const std::vector<std::vector<int>>& families,
               const std::set<std::string>& no_skip);

}  // namespace caustic::solver
