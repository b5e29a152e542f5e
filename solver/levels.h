// The levels of a request, resolved against what the receiver sees.
#pragma once

#include <optional>
#include <vector>

#include "solver/contours.h"

namespace caustic::solver {

/// Irradiance on a piece of the receiver of some area.
struct WeightedIrradiance {
  double irradiance;  ///< W/m²
  double area;        ///< m²
};

/// Smallest value below which `share` of the area lies; nothing without samples.
std::optional<double> percentile(std::vector<WeightedIrradiance> samples, double share);

/// Ascending, without repetition. Empty if min or max is missing and there are no samples, or if
/// min > max.
std::vector<double> resolve_levels(const LevelRequest& request,
                                   const std::vector<WeightedIrradiance>& samples);

}  // namespace caustic::solver
