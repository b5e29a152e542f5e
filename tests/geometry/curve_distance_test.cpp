// The distance between curves by which methods are judged: against distances known beforehand.
#include "tests/support/curve_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace caustic::test {
namespace {

using geometry::kPi;
using geometry::Vec2;

Line circle(double radius, int n) {
  Line line;
  for (int i = 0; i <= n; ++i) {
    const double t = 2.0 * kPi * i / n;
    line.push_back(radius * Vec2(std::cos(t), std::sin(t)));
  }
  return line;
}

TEST(CurveDistance, OfAPolygonIsThatOfItsChords) {
  const NearestOnLines truth({circle(1.0, 40'000)});  // up to 3e-9
  for (const int n : {4, 16, 256}) {
    const auto found = distances({circle(1.0, n)}, truth, {0}, 1, {0.1, 5}, 9.0)[0];
    const double sag = 1.0 - std::cos(kPi / n);
    EXPECT_NEAR(found.max, sag, 1e-8) << n;
    EXPECT_NEAR(found.length, 2.0 * n * std::sin(kPi / n), 1e-9);
    // The mean of 1 − √(c² + x²) over a chord of half length s.
    const double s = std::sin(kPi / n), c = std::cos(kPi / n);
    const double mean = 0.5 - 0.5 * c * c / s * std::asinh(s / c);
    const auto finely = distances({circle(1.0, n)}, truth, {0}, 1, {1e-3, 5}, 9.0)[0];
    // The midpoint rule with k points a chord adds one part in 2k² of a parabola's mean.
    const double k = std::ceil(2.0 * s / 1e-3);
    EXPECT_NEAR(finely.mean(), mean, 0.6 * mean / (k * k) + 1e-8) << n;
  }
}

// From the circle to a polygon the way is as long, from the middle of an arc.
TEST(CurveDistance, SeesWhatIsMissingTheOtherWay) {
  const Line whole = circle(1.0, 20'000), half(whole.begin(), whole.begin() + 10'001);
  const auto there = distances({half}, NearestOnLines({whole}), {0}, 1, {0.1, 5}, 9.0)[0];
  const auto back = distances({whole}, NearestOnLines({half}), {0}, 1, {0.1, 1}, 9.0)[0];
  EXPECT_LT(there.max, 1e-12);
  EXPECT_NEAR(back.max, std::sqrt(2.0), 1e-7);  // from (0, −1) to an end
}

TEST(CurveDistance, TellsKindsApart) {
  const std::vector<Line> others{{{0, 0}, {1, 0}}, {{0, 1}, {1, 1}}};
  const auto found = distances({{{0.1, 0.2}, {0.9, 0.2}}, {{0.1, 0.9}, {0.5, 0.9}}},
                               NearestOnLines(others), {1, 0}, 2, {0.01, 1}, 9.0);
  EXPECT_NEAR(found[1].max, 0.2, 1e-15);
  EXPECT_NEAR(found[1].length, 0.8, 1e-12);
  EXPECT_NEAR(found[0].max, 0.1, 1e-15);
  EXPECT_NEAR(found[0].mean(), 0.1, 1e-15);
  EXPECT_NEAR(found[0].length, 0.4, 1e-12);
}

TEST(CurveDistance, OfNothingIsWhatWasSaid) {
  const auto found = distances({{{0, 0}, {1, 0}}}, NearestOnLines({}), {}, 2, {0.01, 1}, 3.0);
  EXPECT_EQ(found[0].max, 3.0);
  EXPECT_NEAR(found[0].mean(), 3.0, 1e-12);
  EXPECT_EQ(found[1].length, 0.0);
  EXPECT_EQ(distances({}, NearestOnLines({}), {}, 1, {0.01, 1}, 3.0)[0].max, 0.0);
}

// The tree of boxes finds what looking at every segment finds, whatever the hint.
TEST(CurveDistance, FindsTheNearestOfAll) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (const int count : {1, 3, 40}) {
    std::vector<Line> lines(count);
    for (Line& line : lines) {
      Vec2 q(any(random), any(random));
      for (int i = 0; i < 1 + static_cast<int>(random() % 30); ++i)
        line.push_back(q += 0.1 * Vec2(any(random), any(random)));
    }
    const NearestOnLines tree(lines);
    for (int i = 0; i < 500; ++i) {
      const Vec2 q(2.0 * any(random), 2.0 * any(random));
      double least = geometry::kInfinity;
      for (const Line& line : lines)
        for (const auto& place : {NearestOnLines({line}).to(q)})
          least = std::min(least, place.distance);
      EXPECT_EQ(tree.to(q, random() % 2000).distance, least);
    }
  }
}

}  // namespace
}  // namespace caustic::test
