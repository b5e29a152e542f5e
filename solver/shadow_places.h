// Where shadows of surfaces lie on the receiver, however small they are.
#pragma once

#include <vector>

#include "solver/optical_system.h"

namespace caustic::solver {

/// For each surface, places of the receiver's window that it probably keeps the direct light from:
/// behind the middle of its box, then behind others in it.
std::vector<std::vector<geometry::Point>> places_behind_surfaces(const OpticalSystem& system);

}  // namespace caustic::solver
