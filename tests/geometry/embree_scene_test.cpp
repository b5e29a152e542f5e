#include "geometry/embree_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace caustic::geometry {
namespace {

// Every box that a segment meets by the slab test in double precision is among the candidates, at
// any scale and far from the origin.
TEST(EmbreeScene, no_box_is_missed) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    const Point offset = 1e3 * scale * Point(1, -2, 3);
    std::vector<Box> boxes;
    for (int i = 0; i < 300; ++i) {
      const Point c(uniform(random), uniform(random), uniform(random));
      boxes.push_back(Box::around(offset + scale * c, scale * 0.05 * std::abs(uniform(random))));
    }
    boxes.push_back(Box{});  // unbounded
    const EmbreeScene scene(boxes, 0.0);
    std::size_t met = 0, proposed = 0;
    for (int i = 0; i < 2000; ++i) {
      const Point a(uniform(random), uniform(random), uniform(random));
      const Point b(uniform(random), uniform(random), uniform(random));
      const Ray ray{offset + scale * a, scale * (b - a)};
      std::vector<int> found;
      scene.candidates(ray, 1.0, found);
      proposed += found.size();
      for (int k = 0; k < static_cast<int>(boxes.size()); ++k) {
        if (!boxes[k].may_meet(ray, 0.0)) continue;
        ++met;
        ASSERT_TRUE(std::binary_search(found.begin(), found.end(), k)) << scale << " " << k;
      }
    }
    EXPECT_GT(met, 2200u);  // of which 2000 the unbounded box
    EXPECT_LT(proposed, 4 * met);  // they are candidates, not everything
  }
}

// Light that arrives where the mirror touches the receiver goes no way there; next to a pole it goes
// further than floats reach. Embree ends the process for such a ray.
TEST(EmbreeScene, what_is_no_ray_in_single_precision) {
  std::vector<Box> boxes;
  for (int i = 0; i < 100; ++i) boxes.push_back(Box::around({3.0 * i, 0, 0}, 1.0));
  const EmbreeScene scene(boxes, 0.0);
  const auto candidates = [&](const Ray& ray) {
    std::vector<int> found;
    scene.candidates(ray, 1.0, found);
    return found;
  };
  EXPECT_EQ(candidates({{150.2, 0.1, 0}, {0, 0, 0}}), std::vector{50});
  EXPECT_EQ(candidates({{150.2, 0.1, 0}, {-0.0, 1e-320, 0}}), std::vector{50});
  const auto far = candidates({{150.2, 0.1, 0}, {0, 0, 1e200}});
  EXPECT_TRUE(std::binary_search(far.begin(), far.end(), 50));
  EXPECT_EQ(candidates({{150.2, 0.1, 1e50}, {0, 0, -2e50}}), std::vector{50});
  EXPECT_EQ(candidates({{0, 0, 0}, {kInfinity, 0, 0}}).size(), boxes.size());
  EXPECT_EQ(candidates({{0, 0, 0}, {std::nan(""), 0, 0}}).size(), boxes.size());
  EXPECT_EQ(candidates({{std::nan(""), 0, 0}, {1, 0, 0}}).size(), boxes.size());
}

TEST(EmbreeScene, margin_widens) {
  std::vector<Box> boxes;
  for (int i = 0; i < 100; ++i) boxes.push_back(Box::around({3.0 * i, 0, 0}, 1.0));
  const EmbreeScene wide(boxes, 0.5);
  const Ray beside{{151.4, 0, -5}, {0, 0, 10}};
  std::vector<int> found;
  wide.candidates(beside, 1.0, found);
  EXPECT_TRUE(std::binary_search(found.begin(), found.end(), 50));
  EXPECT_LT(found.size(), 20u);
}

}  // namespace
}  // namespace caustic::geometry
