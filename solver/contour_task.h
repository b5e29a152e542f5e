// All curves of one level on one field: seeds settled, curves traced once each, visibility cut.
#pragma once

#include <cstddef>
#include <vector>

#include "solver/family_field.h"
#include "solver/trace_contour.h"

namespace caustic::solver {

struct ContourTask {
  const FamilyField* field;
  LevelFunction level;
  double irradiance;  ///< W/m² as asked for, −1 for the caustic
  std::vector<Seed> seeds;
  bool seen_only = true;       ///< cut where something hides the light
  std::vector<Trace> traces;   ///< result: the visible pieces
  std::size_t lost_seeds = 0;  ///< result: seeds that could not be brought onto a curve
};

/// Tasks share nothing but the budget, so they may run in any order on any thread.
void run(ContourTask& task, Budget& budget, double chord, double residual);

/// A trace as the answer has it: oriented with the brighter side on the left (seen with u right and
/// v up; caustics from their smaller end), with arc lengths and residuals against the level asked
/// for.
Curve finish(Trace trace, const ContourTask& task, const geometry::ReceiverFrame& receiver);

/// By kind, level, family, then smallest (u, v).
void sort_curves(std::vector<Curve>& curves);

}  // namespace caustic::solver
