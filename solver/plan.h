// What a scene needs: the pieces of its families that have to be explored, whether anything can be
// hidden, whether Embree pays. What is left out is named, with the reason.
#pragma once

#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "solver/contours.h"
#include "solver/hop.h"
#include "solver/itineraries.h"

namespace caustic::solver {

/// Of the direct light, which is no family that was asked for.
constexpr int kDirectFamily = -1;

/// What a piece is asked although it needs not, for measuring.
struct Needless {
  bool third_derivatives = false;  ///< of quadrics
  bool unseen_cells = false;       ///< refined as if their light came to the receiver
  bool hidden_family = false;      ///< traced though no gap shows anything of it
};

/// One family, with the side from which light comes to each of its surfaces.
struct PlannedPiece {
  int family;
  Hops hops;
  bool visibility;  ///< something may be hidden
  Needless needless{};
};

struct Plan {
  std::vector<PlannedPiece> pieces;
  std::optional<PlannedPiece> direct;  ///< if asked for, and if it falls on the receiver at all
  bool embree = false;
  std::vector<Skipped> skipped;
};

/// What `no_skip` may name, in the order of a request. "empty_levels" is in `skipped` but not here:
/// a level that lies on no edge of a cell costs nothing that could be saved or spent.
std::span<const char* const> skippable_stages();

/// `families` by surface index, and the direct light. Stages named in `no_skip` run in any case.
Plan make_plan(const OpticalSystem& system, const std::vector<std::vector<int>>& families,
               bool direct, const std::set<std::string>& no_skip,
               const OutOfTime& out_of_time = {});

}  // namespace caustic::solver
