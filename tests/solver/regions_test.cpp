// Faces between boundaries: how many sheets arrive, by roots of one variable and by the meter, and
// that each part of the receiver that a grid can tell apart is one of them.
#include "solver/regions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

#include "solver/deepest_point.h"
#include "solver/point_irradiance.h"
#include "tests/support/strips.h"
#include "tests/support/thorough.h"
#include "tests/support/total_scenes.h"

namespace caustic::solver {
namespace {

ContourResult regions_of(const OpticalSystem& system) {
  ContourRequest request;
  request.measure = Measure::total;
  request.isolux = request.caustic = false;
  request.boundaries = request.regions = true;
  request.time_limit = 60.0;
  ContourResult result = trace_contours(system, request);
  EXPECT_FALSE(result.unsupported);
  EXPECT_EQ(result.undecided_cells, 0u);
  LightMeter meter(system, {}, false);
  for (const Region& region : result.regions) {
    EXPECT_EQ(static_cast<int>(meter.at(region.uv_inside).sheets.size()), region.branches)
        << region.uv_inside.transpose();
  }
  return result;
}

/// How many regions there are of each number of sheets.
std::map<int, int> numbers_of(const ContourResult& result) {
  std::map<int, int> numbers;
  for (const Region& region : result.regions) ++numbers[region.branches];
  return numbers;
}

bool crosses(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const auto turn = [](const Vec2& p, const Vec2& q, const Vec2& r) {
    return (q - p).x() * (r - p).y() - (q - p).y() * (r - p).x() > 0.0;
  };
  return turn(a, b, c) != turn(a, b, d) && turn(c, d, a) != turn(c, d, b);
}

/// Points of a grid, and the points inside of regions, are one part if they are neighbours and no
/// boundary runs between. Each part of many points has exactly one point inside, and each such
/// point its own part. A region with a neck too narrow for the grid is several parts: then its
/// other parts must at least have as many sheets as some region.
void expect_all_parts(const OpticalSystem& system, const ContourResult& result,
                      bool has_necks = false) {
  constexpr int n = test::thorough(48, 16), kMany = 12;
  const Vec2 half = system.receiver().half;
  std::vector<Vec2> places;
  for (int k = 0; k < n * n; ++k)
    places.push_back(
        half.cwiseProduct(Vec2(2.0 * (k % n + 0.47) / n - 1.0, 2.0 * (k / n + 0.53) / n - 1.0)));
  for (const Region& region : result.regions) places.push_back(region.uv_inside);
  std::vector<std::size_t> part(places.size());
  std::iota(part.begin(), part.end(), 0u);
  const auto root = [&](std::size_t k) {
    while (part[k] != k) k = part[k] = part[part[k]];
    return k;
  };
  const auto connect = [&](std::size_t i, std::size_t j) {
    for (const Curve& c : result.curves) {
      const auto& v = c.vertices;
      for (std::size_t k = 0; k + !c.closed < v.size(); ++k) {
        if (crosses(places[i], places[j], v[k].uv, v[(k + 1) % v.size()].uv)) return;
      }
    }
    part[root(i)] = root(j);
  };
  for (int k = 0; k < n * n; ++k) {
    if (k % n + 1 < n) connect(k, k + 1);
    if (k + n < n * n) connect(k, k + n);
  }
  for (std::size_t r = n * n; r < places.size(); ++r) {
    for (int k = 0; k < n * n; ++k) {
      if (((places[k] - places[r]).array().abs() < 2.1 / n * half.array()).all()) connect(r, k);
    }
  }
  std::map<std::size_t, int> sizes, insides;
  for (std::size_t k = 0; k < places.size(); ++k) ++(k < n * n ? sizes : insides)[root(k)];
  for (const auto& [at, size] : sizes) {
    if (size < kMany) continue;
    if (has_necks && insides[at] == 0) {
      const auto sheets = LightMeter(system, {}, false).at(places[at]).sheets.size();
      EXPECT_TRUE(numbers_of(result).contains(static_cast<int>(sheets))) << sheets;
    } else {
      EXPECT_EQ(insides[at], 1) << size << " points about " << places[at].transpose();
    }
  }
  for (const auto& [at, count] : insides) EXPECT_LE(count, 1) << places[at].transpose();
}

TEST(Regions, OfOneSheetIsTheReceiver) {
  const auto result = regions_of(test::ball_under_ceiling());
  ASSERT_EQ(result.regions.size(), 1u);
  EXPECT_EQ(result.regions[0].branches, 1);
  EXPECT_LT(result.regions[0].uv_inside.norm(), 0.1);  // of 12 m
}

TEST(Regions, OfOverlappingPatches) {
  const auto result = regions_of(test::two_plates());
  EXPECT_EQ(numbers_of(result), (std::map<int, int>{{0, 1}, {1, 2}, {2, 1}}));
  expect_all_parts(test::two_plates(), result);
}

// Outside of the nephroid and inside, and what of that the arc's ends and its height leave: light
// from (cos φ, sin φ) arrives on the line from there along (cos 2φ, sin 2φ), up to 1 away.
TEST(Regions, OfTheNephroidRing) {
  const auto result = regions_of(test::nephroid_ring());
  for (const Region& region : result.regions) {
    const Vec2 q = region.uv_inside + Vec2(0.5, 0.0);
    const auto beside = [&](double phi) {
      return (q.x() - std::cos(phi)) * std::sin(2 * phi) -
             (q.y() - std::sin(phi)) * std::cos(2 * phi);
    };
    int sheets = 0;
    constexpr int kSteps = 3000;
    for (int k = 0; k < kSteps; ++k) {
      const double a = geometry::kPi / 3 * (2.0 * k / kSteps - 1.0),
                   b = geometry::kPi / 3 * (2.0 * (k + 1) / kSteps - 1.0);
      if ((beside(a) > 0.0) == (beside(b) > 0.0)) continue;
      const double phi = test::root_of(beside, a, b);
      const double z =
          (std::cos(phi) - q.x()) * std::cos(2 * phi) + (std::sin(phi) - q.y()) * std::sin(2 * phi);
      sheets += z > 0.0 && z < 1.0;
    }
    EXPECT_EQ(region.branches, sheets) << q.transpose();
  }
  EXPECT_EQ(numbers_of(result), (std::map<int, int>{{0, 2}, {1, 3}, {2, 2}, {3, 1}}));
  expect_all_parts(test::nephroid_ring(), result);
}

TEST(Regions, AmongManyCaustics) {
  for (const auto& [system, has_necks] :
       {std::pair{test::tilted_dish(), false}, std::pair{test::torus_beside_lamp(), false},
        std::pair{test::crossing_waves(), true}, std::pair{test::cuboid_over_floor(), true}}) {
    const auto result = regions_of(system);
    EXPECT_GE(result.regions.size(), 2u);
    expect_all_parts(system, result, has_necks);
    if (test::kSanitized) break;  // one has cusps, crossings and edges
  }
}

TEST(DeepestPoint, OfAFrameLiesInItsWidestPart) {
  // 4 × 2 with a hole: 1 wide at the left, 2 at the right, ½ above and below.
  const std::vector<std::vector<Vec2>> frame{{{0, 0}, {4, 0}, {4, 2}, {0, 2}},
                                             {{1, 0.5}, {1, 1.5}, {2, 1.5}, {2, 0.5}}};
  EXPECT_GT(twice_area(frame[0]), 0.0);
  EXPECT_LT(twice_area(frame[1]), 0.0);
  const DeepestPoint found = deepest_point(frame, 1e-3);
  EXPECT_NEAR(found.depth, 1.0, 1e-3);
  EXPECT_NEAR(found.at.x(), 3.0, 5e-3);
  EXPECT_NEAR(found.at.y(), 1.0, 5e-3);
  EXPECT_TRUE(surrounds(frame[0], found.at));
  EXPECT_FALSE(surrounds(frame[1], found.at));
}

}  // namespace
}  // namespace caustic::solver
