// Surfaces of revolution against other shapes and at their ends; what all surfaces promise is in
// surface_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/surface.h"
#include "tests/support/random.h"

namespace caustic::geometry {
namespace {

using test::Random;

SurfacePtr revolution(double height, const std::vector<double>& profile) {
  return make_revolution(Point::Zero(), {0, 0, 1}, height, profile).surface;
}

std::vector<double> crossings(const Surface& surface, const Ray& ray, double t0, double t1) {
  std::vector<double> found;
  surface.crossings(ray, t0, t1, found);
  return found;
}

TEST(Revolution, LinearProfilesAreCylindersAndCones) {
  Random random(1);
  const Point origin(0.2, -0.4, 0.1);
  const Direction axis = random.direction();
  const auto tube = make_cylinder(origin, axis, 0.8),
             cone = make_cone(origin, axis, std::atan(0.5));
  const auto as_tube = make_revolution(origin, axis, 3.0, {0.8}).surface;
  const auto as_cone = make_revolution(origin, axis, 2.0, {0.0, 1.0}).surface;
  int checked = 0;
  for (int i = 0; i < 300; ++i) {
    const Ray ray{random.in_cube(3.0), random.direction()};
    for (const auto& [a, b] : {std::pair(tube, as_tube), std::pair(cone, as_cone)}) {
      const auto expected = crossings(*a, ray, -9.0, 9.0), found = crossings(*b, ray, -9.0, 9.0);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t k = 0; k < found.size(); ++k) {
        EXPECT_NEAR(found[k], expected[k], 1e-12);
        ++checked;
      }
    }
  }
  EXPECT_GT(checked, 300);
  EXPECT_TRUE(as_tube->convex(1));
  EXPECT_FALSE(as_cone->convex(1));
}

// Rays across the axis next to the narrowest place of a neck: a part that thin must be seen.
TEST(Revolution, NecksAreFoundHoweverThin) {
  for (const double neck : {1e-1, 1e-4, 1e-8}) {
    const auto surface = revolution(2.0, {0.5 + neck, -2.0, 2.0});  // R = neck + ½(z − 1)²
    for (const double share : {0.0, 0.5, 0.99, 1.01}) {
      const auto found = crossings(*surface, {{-50.0, share * neck, 1.0}, {1, 0, 0}}, 0.0, 100.0);
      ASSERT_EQ(found.size(), share < 1.0 ? 2u : 0u) << neck << " " << share;
      if (share > 1.0) continue;
      const double half = neck * std::sqrt(1.0 - share * share);
      EXPECT_NEAR(found[0], 50.0 - half, 1e-13);
      EXPECT_NEAR(found[1], 50.0 + half, 1e-13);
    }
    // A ray down the axis never meets it.
    EXPECT_TRUE(crossings(*surface, {{0, 0, 4.0}, {0, 0, -1}}, 0.0, 8.0).empty());
  }
}

TEST(Revolution, BoundsFitAndChartsEndBesideTheEnds) {
  const auto vase = revolution(2.0, {0.47, 3.90, -9.78, 5.80});
  const Box box = vase->bounds();
  EXPECT_DOUBLE_EQ(box.min.z(), 0.0);
  EXPECT_DOUBLE_EQ(box.max.z(), 2.0);
  // R' = 0 at w = (19.56 − √(19.56² − 4·17.4·3.9))/34.8.
  const double w = (19.56 - std::sqrt(19.56 * 19.56 - 4.0 * 17.4 * 3.9)) / 34.8;
  EXPECT_NEAR(box.max.x(), 0.47 + w * (3.90 + w * (-9.78 + w * 5.80)), 1e-14);
  EXPECT_DOUBLE_EQ(box.min.y(), -box.max.x());
  const auto ends = vase->own_bounds();
  ASSERT_EQ(ends.size(), 2u);
  const auto chart = vase->charts({box, box.center(), 1.0}).at(0);
  EXPECT_GT(ends[0].value(chart.point(0.3, 0.0)), 0.0);
  EXPECT_GT(ends[1].value(chart.point(0.3, 1.0)), 0.0);
}

TEST(Revolution, RefusesRadiiThatVanishBetweenTheEnds) {
  const auto sound = [](const std::vector<double>& profile) {
    const auto result = make_revolution(Point::Zero(), {0, 0, 1}, 2.0, profile);
    EXPECT_EQ(result.surface == nullptr, !result.fault.empty());
    return result.surface != nullptr;
  };
  EXPECT_TRUE(sound({0.1}));
  EXPECT_TRUE(sound({0.0, 1.0}));
  EXPECT_TRUE(sound({0.3, -0.1, -0.2}));  // zero at the top but for rounding
  EXPECT_TRUE(sound({0.0, 1.0, -1.0}));   // at both ends
  EXPECT_TRUE(sound({1.0, -1.0, 0.26}));
  EXPECT_TRUE(sound({0.0, 0.0, 1.0}));
  EXPECT_FALSE(sound({}));
  EXPECT_FALSE(sound({0.0}));
  EXPECT_FALSE(sound({-1.0}));
  EXPECT_FALSE(sound({0.5, -1.0}));
  EXPECT_FALSE(sound({-0.5, 1.0}));
  EXPECT_FALSE(sound({0.25, -1.0, 1.0}));  // touches zero in the middle
  EXPECT_FALSE(sound({0.2, -1.0, 1.0}));   // dips below it
  EXPECT_FALSE(sound({0.0, -1.0, 2.0}));
}

}  // namespace
}  // namespace caustic::geometry
