// What a light meter reads on the whole receiver: flux, extremes, uniformity, and for each level
// the area where the total is at least that and the flux onto it. NOTATION.md (S60)–(S63).
#pragma once

#include "solver/contours.h"

namespace caustic::solver {

/// A number that is off by no more than `error`.
struct Estimate {
  double value = 0.0, error = 0.0;
};

struct LevelAnalysis {
  double level;   ///< W/m²
  Estimate area;  ///< where the total is at least `level`, m²
  Estimate flux;  ///< onto that, W
};

struct Analysis {
  std::optional<std::string> unsupported;  ///< what of the request this version lacks
  bool complete = true;                    ///< false if a limit cut the work short
  Estimate flux;                           ///< onto the receiver, W
  Estimate average;                        ///< of the irradiance over the receiver, W/m²
  std::vector<LevelAnalysis> levels;       ///< ascending
  std::size_t undecided = 0;  ///< places that could not be settled: errors do not know of them
  std::vector<Warning> warnings;
};

/// Of the request's measure only `total` is meant here; what it returns of curves is not wanted.
Analysis analyse(const OpticalSystem& system, ContourRequest request);

}  // namespace caustic::solver
