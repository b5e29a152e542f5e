// Does anything show of a piece of a family all of whose samples are hidden? A narrow gap may lie
// between them.
#pragma once

#include "solver/explore.h"
#include "solver/visibility.h"

namespace caustic::solver {

/// True if a place is found that is seen. Cells are divided until what hides the middle of each
/// part hides the whole of it, by its room (S13), or parts are too small.
bool shows_through_gap(Evaluator& evaluate, const Domain& domain, const Exploration& e,
                       const Visibility& visibility, const Hops& hops);

}  // namespace caustic::solver
