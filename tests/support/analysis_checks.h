// Whole analyses that must not lack anything, and what their estimates are held to.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "solver/analysis.h"

namespace caustic::test {

inline solver::Analysis analysis_of(const solver::OpticalSystem& system, std::vector<double> levels,
                                    double chord = 0.0) {
  solver::ContourRequest request;
  request.levels.values = std::move(levels);
  request.chord_tolerance = chord;
  request.time_limit = 60.0;
  solver::Analysis analysis = analyse(system, request);
  EXPECT_FALSE(analysis.unsupported) << *analysis.unsupported;
  EXPECT_TRUE(analysis.complete);
  EXPECT_EQ(analysis.undecided, 0u);
  for (const solver::Warning& w : analysis.warnings) ADD_FAILURE() << w.code << ": " << w.detail;
  return analysis;
}

/// The estimate holds, and is worth something. The expected value is good to 1e-12.
inline void expect_holds(const solver::Estimate& found, double expected, double largest_error) {
  const double rounding = 1e-12 * std::abs(expected);
  EXPECT_LE(std::abs(found.value - expected), found.error + rounding) << found.value;
  EXPECT_LE(found.error, largest_error);
}

}  // namespace caustic::test
