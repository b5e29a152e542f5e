// Curves are traced as if nothing were hidden; here they are cut where visibility changes. So a piece
// that shows in a narrow gap is found, and tracing does not depend on visibility.
#pragma once

#include <vector>

#include "solver/evaluator.h"
#include "solver/level_function.h"
#include "solver/trace_contour.h"
#include "solver/visibility.h"

namespace caustic::solver {

/// The visible pieces of a traced curve, in order; the curve itself if nothing of it is hidden.
/// Their new ends are `shadow` or `occlusion`, located to the rounding of x. `residual` is what the
/// corrector aims at.
std::vector<Trace> visible_pieces(Trace trace, const Visibility& visibility, Evaluator& evaluate,
                                  const LevelFunction& level, double residual);

}  // namespace caustic::solver
