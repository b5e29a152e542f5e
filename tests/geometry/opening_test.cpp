#include "geometry/opening.h"

#include <gtest/gtest.h>

#include <cmath>

namespace caustic::geometry {
namespace {

// Discs on a plane: the margin of a cylinder's bound is r/2 on its axis.
TEST(OpeningRadius, small_parts_are_found_from_afar) {
  const auto plane = make_plane({0, 0, 0}, {0, 0, 1});
  for (const double r : {1.0, 1e-2, 1e-5}) {
    const std::vector<Bound> bounds{cylinder_aperture({0.3, -0.7, 0}, {0, 0, 1}, r)};
    EXPECT_NEAR(opening_radius(*plane, bounds, {{50, 20, 0}}, 10.0), 0.5 * r, 0.1 * r) << r;
  }
}

TEST(OpeningRadius, a_box_on_a_sphere) {
  const auto sphere = make_sphere({0, 0, 0}, 1.0);
  const auto bounds = box_aperture({-0.1, -0.02, 0}, {0.1, 0.02, 2});
  EXPECT_NEAR(opening_radius(*sphere, bounds, {{0.5, 0.5, -0.7}}, 1.0), 0.02, 0.005);
}

// A cap of height m above a half-space is √(2m) wide, and m is the margin.
TEST(OpeningRadius, a_surface_that_all_but_touches_a_bound) {
  const auto sphere = make_sphere({0, 0, 0}, 1.0);
  for (const double m : {1e-3, 1e-6, 1e-9}) {
    const std::vector<Bound> bounds{half_space_aperture({0, 0, 1 - m}, {0, 0, -1})};
    const double radius = opening_radius(*sphere, bounds, {{0.3, 0, 0.95}}, 0.5);
    EXPECT_LE(radius, 1.01 * std::sqrt(2.0 * m)) << m;
    EXPECT_GT(radius, 0.2 * std::sqrt(2.0 * m)) << m;
  }
}

TEST(OpeningRadius, stops_at_enough_and_says_when_nothing_exists) {
  const auto sphere = make_sphere({0, 0, 0}, 1.0);
  EXPECT_EQ(opening_radius(*sphere, {}, {}, 0.25), 0.25);
  EXPECT_EQ(opening_radius(*sphere, {half_space_aperture({0, 0, 0}, {0, 0, 1})}, {{1, 0, 0}}, 0.25),
            0.25);
  const std::vector<Bound> outside{half_space_aperture({0, 0, 2}, {0, 0, -1})};
  EXPECT_LT(opening_radius(*sphere, outside, {{1, 0, 0}, {0, 0, 1}}, 0.25), 0.0);
}

}  // namespace
}  // namespace caustic::geometry
