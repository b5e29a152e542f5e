// Which families occur, and from which side light comes to their surfaces: found by following some
// thousand rays, without derivatives.
#pragma once

#include <functional>
#include <vector>

#include "solver/hop.h"

namespace caustic::solver {

/// Asked before each ray; once it is true no more are followed, and what was found is returned.
using OutOfTime = std::function<bool()>;

/// Sides from which light comes to the surfaces of a family of at least two hops, for light that
/// comes to the first from `side`. Nothing if no ray gets through, whatever apertures and other
/// surfaces do.
std::vector<Hops> sides_of(const OpticalSystem& system, const std::vector<int>& surfaces, int side,
                           const OutOfTime& out_of_time = {});

/// The families of a request that names none: every surface that passes light on by itself, or, for
/// more than one bounce, those that occur.
enum class Arrival { in_window, anywhere };
std::vector<std::vector<int>> families_up_to(const OpticalSystem& system, int max_bounces,
                                             Arrival arrival = Arrival::in_window,
                                             const OutOfTime& out_of_time = {});

/// All families of at most `max_bounces` hops that some ray takes from the light, nothing in its
/// way, to the receiver's window or wherever it goes: by length, then by surfaces.
std::vector<std::vector<int>> families_that_occur(const OpticalSystem& system, int max_bounces,
                                                  Arrival arrival,
                                                  const OutOfTime& out_of_time = {});

}  // namespace caustic::solver
