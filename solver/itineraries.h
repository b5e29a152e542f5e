// Which families occur, and from which side light comes to their surfaces: found by following some
// thousand rays, without derivatives.
#pragma once

#include <vector>

#include "solver/hop.h"

namespace caustic::solver {

/// Sides from which light comes to the surfaces of a family of at least two hops, for light that comes
/// to the first from `side`. Nothing if no ray gets through, whatever apertures and other surfaces do.
std::vector<Hops> sides_of(const OpticalSystem& system, const std::vector<int>& surfaces, int side);

/// All families of at most `max_bounces` hops that some ray takes from the light to the receiver's
/// window, nothing in its way: by length, then by surfaces.
std::vector<std::vector<int>> families_that_occur(const OpticalSystem& system, int max_bounces);

}  // namespace caustic::solver
