// The true curves, and how far a drawing is from them.
#pragma once

#include <vector>

#include "tests/bench/methods/ours.h"

namespace caustic::bench {

/// What this program draws at a chord far below what is measured; --verify says how true it is.
struct Truth {
  solver::ContourResult result;
  std::vector<std::vector<test::Line>> lines;  ///< of each level
  std::vector<std::vector<int>> kinds;         ///< of each line: a level arc, or a jump
  std::vector<test::NearestOnLines> nearest;
};
inline constexpr int kLevelArc = 0, kJump = 1, kLineKinds = 2;

Truth make_truth(const Scene& scene, solver::Measure measure);

/// In widths of the window, both ways, mean weighted by length; where a level is drawn that does
/// not exist or the other way round, one width.
struct DrawingError {
  test::CurveDistance all, level_arcs;
};
DrawingError error_of(const Scene& scene, const Truth& truth, const Drawing& drawing);

}  // namespace caustic::bench
