// Maxima, minima and saddles of totals and of sheets against closed forms and roots of one
// variable.
#include "solver/critical_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "solver/point_irradiance.h"
#include "tests/support/distance_to.h"
#include "tests/support/scenes.h"
#include "tests/support/strips.h"
#include "tests/support/thorough.h"
#include "tests/support/total_scenes.h"

namespace caustic::solver {
namespace {

using test::floor_at;
using test::one_mirror;
using test::root_of;

ContourResult answer_of(const OpticalSystem& system, Measure measure) {
  ContourRequest request;
  request.measure = measure;
  request.isolux = request.caustic = false;
  request.critical_points = true;
  request.time_limit = 60.0;
  ContourResult result = trace_contours(system, request);
  EXPECT_FALSE(result.unsupported);
  EXPECT_EQ(result.undecided_cells, 0u);
  EXPECT_TRUE(result.curves.empty());
  return result;
}

std::vector<CriticalPlace> critical_points(const OpticalSystem& system, Measure measure) {
  return answer_of(system, measure).critical_points;
}

int count(const std::vector<CriticalPlace>& points, CriticalType type) {
  return static_cast<int>(std::count_if(points.begin(), points.end(),
                                        [&](const CriticalPlace& c) { return c.type == type; }));
}

// A plane mirror shows a lamp at (0.3, 0.2, −2); the foot on the ceiling z = 3 is the brightest
// place.
TEST(CriticalPoints, OfAMirroredLampIsItsFoot) {
  const auto system =
      one_mirror(PointLight{{0.3, 0.2, 2}, 1.5}, geometry::make_plane(Point::Zero(), {0, 0, 1}),
                 floor_at({0, 0, 3}, 4, 3), {}, 0.8);
  for (const Measure measure : {Measure::total, Measure::sheet}) {
    const auto found = critical_points(system, measure);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].type, CriticalType::maximum);
    EXPECT_EQ(found[0].family_id, measure == Measure::total ? -1 : 0);
    EXPECT_LT((found[0].uv - Vec2(0.3, 0.2)).norm(), 1e-9);
    EXPECT_LT((found[0].x - Point(0.3, 0.2, 0.0)).norm(), 1e-9);
    EXPECT_NEAR(found[0].E, 1.5 * 0.8 / 25.0, 1e-13);
  }
}

// Two plane mirrors show their lamp (0, 0, 1) at (±1.2, 0, −0.6), 1.8 below the ceiling.
constexpr double kImage = 1.2, kHeight = 1.8, kShares[2] = {0.9, 0.8};

OpticalSystem two_images() {
  std::vector<SystemSurface> mirrors;
  for (const double side : {-1.0, 1.0}) {
    const Vec3 normal = Vec3(-side * kImage, 0, 1.6).normalized();
    mirrors.push_back(
        test::mirror(geometry::make_plane({side * 0.5 * kImage, 0, 0.2}, normal),
                     geometry::box_aperture({std::min(0.02 * side, 2.0 * side), -3, -1},
                                            {std::max(0.02 * side, 2.0 * side), 3, 2}),
                     kShares[side > 0.0]));
  }
  mirrors[1].name = "right";
  return OpticalSystem::build(PointLight{{0, 0, 1}, 1.0}, mirrors, floor_at({0, 0, 1.2}, 2.8, 1.6));
}

// Along the line through both feet: E and its slope.
double slope_of_images(double u) {
  double sum = 0.0;
  for (const int k : {0, 1}) {
    const double r = u - (k == 0 ? -kImage : kImage);
    sum -= 3.0 * kShares[k] * kHeight * r / std::pow(kHeight * kHeight + r * r, 2.5);
  }
  return sum;
}

TEST(CriticalPoints, OfTwoLampsAreTwoMaximaAndASaddle) {
  const auto found = critical_points(two_images(), Measure::total);
  ASSERT_EQ(found.size(), 3u);  // by u
  const double places[3] = {root_of(slope_of_images, -1.4, -0.5),
                            root_of(slope_of_images, -0.5, 0.5),
                            root_of(slope_of_images, 0.5, 1.4)};
  for (const int k : {0, 1, 2}) {
    EXPECT_EQ(found[k].type, k == 1 ? CriticalType::saddle : CriticalType::maximum);
    EXPECT_NEAR(found[k].uv.x(), places[k], 1e-8);
    EXPECT_NEAR(found[k].uv.y(), 0.0, 1e-9);
    double E = 0.0;
    for (const int m : {0, 1}) {
      const double r = places[k] - (m == 0 ? -kImage : kImage);
      E += kShares[m] * kHeight / std::pow(kHeight * kHeight + r * r, 1.5);
    }
    EXPECT_NEAR(found[k].E, E, 1e-12);
  }
  // Of the sheets: one maximum each, its foot.
  const auto sheets = critical_points(two_images(), Measure::sheet);
  ASSERT_EQ(sheets.size(), 2u);
  for (const int k : {0, 1}) {
    EXPECT_EQ(sheets[k].family_id, k);
    EXPECT_NEAR(sheets[k].uv.x(), k == 0 ? -kImage : kImage, 1e-9);
  }
}

// What the meter reads there has no slope, and around them rises and falls as their type says.
void expect_true(const OpticalSystem& system, const std::vector<CriticalPlace>& points) {
  LightMeter meter(system, {}, false);
  const double step = 1e-4 * system.receiver().width();
  for (const CriticalPlace& c : points) {
    const auto here = meter.at(c.uv);
    EXPECT_NEAR(here.E, c.E, 1e-9 * c.E);
    int changes = 0, above = 0;
    constexpr int kAround = test::thorough(64, 16);
    bool last = false;
    for (int k = 0; k <= kAround; ++k) {
      const double angle = 2.0 * geometry::kPi * k / kAround;
      const bool up = meter.at(c.uv + step * Vec2(std::cos(angle), std::sin(angle))).E > c.E;
      changes += k > 0 && up != last;
      above += k > 0 && up;
      last = up;
    }
    const int expected = c.type == CriticalType::saddle ? 4 : 0;
    EXPECT_EQ(changes, expected) << c.uv.transpose();
    if (expected == 0) {
      EXPECT_EQ(above, c.type == CriticalType::minimum ? kAround : 0);
    }
  }
}

// In a disc with ∇E inwards all along its edge maxima and minima are one more than saddles.
TEST(CriticalPoints, OfOneSheetIsOneMaximum) {
  const auto found = critical_points(test::ball_under_ceiling(), Measure::total);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].type, CriticalType::maximum);
}

// Shallow water over a window as large as a wave: a torus, on which there are as many saddles as
// maxima and minima; these are counted among readings on a grid that goes on at its edges.
TEST(CriticalPoints, CountAsMorseSays) {
  const auto waves = test::shallow_crossing_waves();
  const auto found = critical_points(waves, Measure::total);
  expect_true(waves, found);
  LightMeter meter(waves, {}, false);
  constexpr int n = 60;
  std::vector<double> E;
  for (int k = 0; k < n * n; ++k)
    E.push_back(meter.at({(k % n + 0.31) / n - 0.5, (k / n + 0.43) / n - 0.5}).E);
  int extremes[2] = {0, 0};
  for (int k = 0; k < n * n; ++k) {
    for (const int sign : {-1, 1}) {
      bool among = true;
      for (const int j : {n - 1, 0, 1}) {
        for (const int i : {n - 1, 0, 1}) {
          const int other = (k / n + j) % n * n + (k % n + i) % n;
          among &= other == k || sign * E[k] > sign * E[other];
        }
      }
      extremes[sign > 0] += among;
    }
  }
  EXPECT_EQ(count(found, CriticalType::minimum), extremes[0]);
  EXPECT_EQ(count(found, CriticalType::maximum), extremes[1]);
  EXPECT_EQ(count(found, CriticalType::saddle), extremes[0] + extremes[1]);
  EXPECT_GE(extremes[0], 1);
  EXPECT_GE(extremes[1], 1);
}

TEST(CriticalPoints, AmongCausticsAreTrueOfTheMeter) {
  std::size_t places = 0;
  for (const auto& system : {test::nephroid_ring(), test::crossing_waves(), test::tilted_dish()}) {
    const auto found = critical_points(system, Measure::total);
    expect_true(system, found);
    places += found.size();
  }
  EXPECT_GE(places, 5u);
}

// The level just above or below a critical point passes near it: where readings along rays from it
// say so, a curve has been traced.
void expect_curves_beside(const OpticalSystem& system, Measure measure) {
  const double width = system.receiver().width();
  for (const CriticalPlace& c : critical_points(system, measure)) {
    std::vector<Family> families;
    if (measure == Measure::sheet) families = {{c.family_id}};
    LightMeter meter(system, families, false);
    int passed = 0;
    for (const double share : {1.0 - 1e-4, 1.0 + 1e-4}) {
      ContourRequest request;
      request.measure = measure;
      request.levels.values = {share * c.E};
      request.chord_tolerance = 1e-5 * width;
      request.time_limit = 60.0;
      const auto result = trace_contours(system, request);
      // So bright a level lies nearer to a caustic than the chord tolerance, and the answer says
      // so.
      const bool told_apart = c.E < 1000.0;
      EXPECT_TRUE(!told_apart || result.undecided_cells == 0) << c.uv.transpose();
      for (int k = 0; k < 8; ++k) {
        const double angle = 2.0 * geometry::kPi * (k + 0.37) / 8;
        const Vec2 way = 0.02 * width * Vec2(std::cos(angle), std::sin(angle));
        const auto above = [&](double w) {
          return meter.at(c.uv + w * way).E > share * c.E ? 1.0 : -1.0;
        };
        double w = 0.02;
        while (w < 1.0 && above(w) == above(0.0)) w += 0.02;
        if (w >= 1.0) continue;
        const Vec2 q = c.uv + root_of(above, w - 0.02, w) * way;
        double nearest = width;
        for (const Curve& curve : result.curves)
          nearest = std::min(nearest, test::distance_to(curve, q));
        EXPECT_LE(nearest, 1.01e-5 * width)
            << to_string(c.type) << " at " << c.uv.transpose() << " E " << c.E << " " << share;
        ++passed;
      }
    }
    EXPECT_GT(passed, 0);
  }
}

TEST(CriticalPoints, HaveCurvesBesideThem) {
  expect_curves_beside(two_images(), Measure::total);
  if (test::kSanitized) return;
  expect_curves_beside(two_images(), Measure::sheet);
  for (const auto& system : {test::ball_under_ceiling(), test::tilted_dish(),
                             test::crossing_waves(), test::shallow_crossing_waves()})
    expect_curves_beside(system, Measure::total);
}

}  // namespace
}  // namespace caustic::solver
