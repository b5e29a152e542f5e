// What a light meter reads on the whole receiver: flux, extremes, uniformity, and for each level
// the area where the total is at least that and the flux onto it. NOTATION.md (S60)–(S64).
#pragma once

#include "solver/contours.h"

namespace caustic::solver {

/// A number that is off by no more than `error`.
struct Estimate {
  double value = 0.0, error = 0.0;
};

/// The least or the largest total, and where; approached from one side where it jumps.
struct Extreme {
  Estimate E;              ///< W/m²; without meaning where unbounded
  Vec2 q = Vec2::Zero();   ///< receiver axes, m
  bool unbounded = false;  ///< at a caustic
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
  Extreme min, max;
  std::vector<LevelAnalysis> levels;  ///< ascending
  std::size_t undecided = 0;  ///< places that could not be settled; areas and fluxes know of them
  std::vector<Warning> warnings;

  /// E_min/E_avg and E_min/E_max; nothing where no light is.
  std::optional<double> min_to_average() const {
    if (!(average.value > 0.0)) return std::nullopt;
    return min.E.value / average.value;
  }
  std::optional<double> min_to_max() const {
    if (max.unbounded) return 0.0;
    if (!(max.E.value > 0.0)) return std::nullopt;
    return min.E.value / max.E.value;
  }
};

/// Of the request's measure only `total` is meant here; what it returns of curves is not wanted.
Analysis analyse(const OpticalSystem& system, ContourRequest request);

}  // namespace caustic::solver
