// Places of levels on a grid of the receiver, sheet by sheet, by following paths backwards from its
// points: another search, another order of the plane than that of tracing, and families of any
// length.
#pragma once

#include <vector>

#include "solver/contours.h"
#include "solver/find_paths.h"

namespace caustic::test {

struct PlaceOnSheet {
  geometry::Vec2 q;
  double level;
  int parity;
};

struct PlacesOnSheets {
  std::vector<PlaceOnSheet> places;
  int lost = 0;  ///< changes of sign of which the sheet ends on the way
};

/// Where E of one sheet of the family passes one of the levels between neighbours of an n × n grid
/// on the receiver, bisected. Neighbours belong to one sheet if their first hits are each other's
/// nearest by far, and of one parity.
PlacesOnSheets places_on_sheets(const solver::OpticalSystem& system, const solver::Family& family,
                                const std::vector<double>& levels, int n);

}  // namespace caustic::test
