// Contours of the total where their sheets have been proven to be all: vertices against paths found
// anew by interval Newton, which shares nothing with the exploration that traced them.
#include <gtest/gtest.h>

#include "tests/support/thorough.h"
#include "tests/support/total_checks.h"
#include "tests/support/total_scenes.h"

namespace caustic::solver {
namespace {

using test::expect_all_paths_proven;
using test::total_of;

constexpr int kOfCurve = test::thorough(3, 1);

TEST(TotalByProof, OfTheNephroidRing) {
  const auto system = test::nephroid_ring();
  const auto result = total_of(system, {1.0, 2.0, 4.0}, 1.2e-4);
  EXPECT_GT(expect_all_paths_proven(system, result, kOfCurve), 2 * kOfCurve);
}

TEST(TotalByProof, OfATiltedDish) {
  const auto system = test::tilted_dish();
  const auto result = total_of(system, {2.0, 8.0, 40.0}, 6e-5);
  EXPECT_GT(expect_all_paths_proven(system, result, kOfCurve), 2 * kOfCurve);
}

TEST(TotalByProof, OfWavesInTwoDirections) {
  const auto system = test::crossing_waves();
  const auto result = total_of(system, {0.8, 3.0}, 1e-4);
  EXPECT_GT(expect_all_paths_proven(system, result), 4);
}

TEST(TotalByProof, OfACuboid) {
  const auto system = test::cuboid_over_floor();
  const auto result =
      total_of(system, test::kSanitized ? std::vector{0.01} : std::vector{0.001, 0.01}, 8e-4);
  EXPECT_GT(expect_all_paths_proven(system, result), 4);
}

TEST(TotalByProof, OfOverlappingPatches) {
  const auto system = test::two_plates();
  const auto result = total_of(system, {0.05, 0.09, 0.12}, 3e-4);
  EXPECT_GT(expect_all_paths_proven(system, result, kOfCurve), 2 * kOfCurve);
}

}  // namespace
}  // namespace caustic::solver
