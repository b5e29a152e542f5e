// Where to start tracing: places on the curves of all levels at once, from one exploration.
#pragma once

#include <vector>

#include "solver/explore.h"
#include "solver/level_function.h"

namespace caustic::solver {

/// A place on { f = 0 } of one level function, to a share of a cell; the corrector does the rest.
struct Seed {
  int target;   ///< index of its level function
  FieldPoint at;
  double reach; ///< size of the cell it comes from, m
};

/// A stationary point of φ = a/(ρσ) inside the domain.
struct CriticalPoint {
  FieldPoint field;
  int cell;
};

/// Critical points of φ, by Newton's method from the cells whose corners show one.
std::vector<CriticalPoint> find_critical_points(Evaluator& evaluate, const Domain& domain,
                                                const Exploration& e);

/// Crossings of the edges of all cells, of the lines from critical points to the corners, and of the
/// domain's boundary inside the cells, with the levels `targets` (ascending k of S9).
std::vector<Seed> find_seeds(Evaluator& evaluate, Exploration& e,
                             const std::vector<CriticalPoint>& critical,
                             const std::vector<LevelFunction>& targets);

}  // namespace caustic::solver
