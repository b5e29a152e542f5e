// The least and the largest total against readings of a meter and one-dimensional oracles.
#include "solver/total_extremes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "solver/point_irradiance.h"
#include "tests/support/analysis_checks.h"
#include "tests/support/strips.h"
#include "tests/support/thorough.h"
#include "tests/support/total_scenes.h"

namespace caustic::solver {
namespace {

using geometry::kPi;
using test::analysis_of;
using test::expect_holds;

// Before light has met: no caustic, and extremes along lines across.
TEST(TotalExtremes, OfShallowWaterAreBounded) {
  const test::Strips strips = test::strips_of_water(0.4);
  double least = geometry::kInfinity, largest = 0.0;
  constexpr int kSteps = test::thorough(5000, 1000);
  for (int i = 0; i <= kSteps; ++i) {
    const double E = strips.irradiance(1e-9 + (1.0 - 2e-9) * i / kSteps);
    least = std::min(least, E);
    largest = std::max(largest, E);
  }
  const auto analysis = analysis_of(test::water_waves(0.4), {0.9});
  EXPECT_FALSE(analysis.max.unbounded);
  // Samples are 2e-4 apart.
  EXPECT_NEAR(analysis.min.E.value, least, 1e-6);
  EXPECT_NEAR(analysis.max.E.value, largest, 1e-5);
  EXPECT_LE(analysis.min.E.value, least + analysis.min.E.error);
  EXPECT_GE(analysis.max.E.value, largest - analysis.max.E.error);
  for (const Extreme& extreme : {analysis.min, analysis.max}) {
    EXPECT_LE(extreme.E.error, 1e-9);
    expect_holds(extreme.E, strips.irradiance(extreme.q.x() + 0.5), 1e-9);
  }
}

TEST(TotalExtremes, OfOverlappingPatches) {
  const auto system = test::two_plates();
  const auto analysis = analysis_of(system, {0.09});
  // The largest total lies where both patches are: no reading is larger, and some come near.
  LightMeter meter(system, {}, false);
  double largest = 0.0;
  constexpr int kSide = test::thorough(100, 30);
  for (int j = 0; j < kSide; ++j) {
    for (int i = 0; i < kSide; ++i) {
      const Vec2 share((i + 0.5) / kSide - 0.5, (j + 0.5) / kSide - 0.5);
      largest = std::max(largest, meter.at(3.0 * share).E);
    }
  }
  EXPECT_GE(analysis.max.E.value + analysis.max.E.error, largest);
  EXPECT_LE(analysis.max.E.value, 1.05 * largest);
  // It is a corner of where they overlap, and read on one side of it only.
  double beside = 0.0;
  for (int k = 0; k < 16; ++k) {
    const double angle = 2.0 * kPi * k / 16.0;
    beside = std::max(beside,
                      meter.at(analysis.max.q + 1e-6 * Vec2(std::cos(angle), std::sin(angle))).E);
  }
  EXPECT_NEAR(beside, analysis.max.E.value, 1e-5);
  EXPECT_EQ(meter.at(analysis.min.q).E, 0.0);
}

}  // namespace
}  // namespace caustic::solver
