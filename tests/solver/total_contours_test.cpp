// Contours of the total irradiance: against the sheets where there is one, against all paths found
// anew, against areas by random points.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "solver/contours.h"
#include "solver/point_irradiance.h"
#include "tests/support/distance_to.h"
#include "tests/support/scenes.h"
#include "tests/support/strips.h"
#include "tests/support/thorough.h"
#include "tests/support/total_checks.h"
#include "tests/support/total_scenes.h"

namespace caustic::solver {
namespace {

using geometry::kPi;
using test::area_above;
using test::expect_areas;
using test::expect_closed_rings;
using test::expect_true_of_the_meter;
using test::total_of;

std::vector<const Curve*> rings_of(const ContourResult& result, double level, int& count) {
  std::vector<const Curve*> arcs;
  std::map<int, int> ids;
  for (const Curve& c : result.curves) {
    if (c.level != level) continue;
    arcs.push_back(&c);
    ids[c.ring_id] = 1;
  }
  count = static_cast<int>(ids.size());
  return arcs;
}

TEST(TotalContours, OfOneSheetAreTheSheets) {
  const auto system = test::ball_under_ceiling();
  const std::map<double, double> radii{{5e-4, 2.64148155}, {3e-4, 4.60955767}};
  const auto total = total_of(system, {5e-4, 3e-4, 1.8e-4}, 1e-4);
  EXPECT_EQ(total.undecided_cells, 0u);
  expect_closed_rings(total, 12.0);
  for (const auto& [level, radius] : radii) {
    int rings = 0;
    const auto arcs = rings_of(total, level, rings);
    ASSERT_EQ(arcs.size(), 1u);
    EXPECT_TRUE(arcs[0]->closed);
    for (const CurveVertex& v : arcs[0]->vertices) EXPECT_NEAR(v.uv.norm(), radius, 1e-7);
    EXPECT_NEAR(area_above(total, level), kPi * radius * radius, 2.0 * kPi * radius * 1e-4);
  }
  // The third circle leaves through the four sides: four arcs and four pieces of the edge, one
  // ring.
  int rings = 0;
  EXPECT_EQ(rings_of(total, 1.8e-4, rings).size(), 8u);
  EXPECT_EQ(rings, 1);
}

// 10⁻⁸ above a tilted mirror rounding of the reflector point alone moves E by 10⁻⁸ of it: levels
// are followed as nearly as that allows, and the answer says so. By the lamp's image.
TEST(TotalContours, OfALampNextToItsMirror) {
  const Vec3 n = Vec3(0.3, 0.2, 1).normalized();
  const Point on(0.31, 0.27, -0.11), image = on - 1e-8 * n;
  const double height = 0.9;
  const auto system = OpticalSystem::build(
      PointLight{on + 1e-8 * n, 1.0},
      {test::mirror(geometry::make_plane(on, n), geometry::box_aperture({-2, -2, -2}, {2, 2, 2}))},
      test::floor_at({0, 0, height}, 2, 2));
  const auto total = total_of(system, {0.4, 0.7, 0.9}, 1e-4);
  EXPECT_EQ(total.undecided_cells, 0u);
  for (const auto& w : total.warnings) EXPECT_EQ(w.code, "conditioning");
  EXPECT_EQ(total.warnings.size(), 1u);
  expect_closed_rings(total, 2.0);
  int vertices = 0;
  for (const Curve& c : total.curves) {
    if (c.kind != CurveKind::isolux) continue;
    for (const CurveVertex& v : c.vertices) {
      const Vec3 way = Point(v.uv.x(), v.uv.y(), height) - image;
      EXPECT_NEAR(way.z() / std::pow(way.norm(), 3) / c.level, 1.0, 1e-6);
      ++vertices;
    }
  }
  EXPECT_GT(vertices, 50);
}

// A coarse polyline may pass points of the grid on the wrong side; its arc is not traced again.
TEST(TotalContours, DrawnCoarselyAreDrawnOnce) {
  const auto system = test::ball_under_ceiling();
  for (const double chord : {1e-3, 1e-2, 0.1}) {
    std::vector<double> levels;
    for (int i = 0; i < 10; ++i) levels.push_back(3e-4 + 2e-5 * i);
    const auto total = total_of(system, levels, chord);
    EXPECT_EQ(total.undecided_cells, 0u) << chord;
    for (const double level : levels) {
      int rings = 0;
      EXPECT_EQ(rings_of(total, level, rings).size(), 1u) << chord << ' ' << level;
    }
  }
}

TEST(TotalContours, OfTheNephroidRing) {
  const auto system = test::nephroid_ring();
  const auto result = total_of(system, {1.0, 2.0, 4.0}, 1.2e-4);
  ASSERT_FALSE(result.unsupported);
  EXPECT_EQ(result.undecided_cells, 0u);
  EXPECT_TRUE(result.warnings.empty());
  expect_closed_rings(result, 1.2);
  expect_true_of_the_meter(system, result);
  expect_areas(system, result, 1.2e-4);
}

// Without levels, the edges of all sheets with what a meter reads next to them.
TEST(TotalContours, KnowWhatLiesOnBothSidesOfBoundaries) {
  const auto system = test::two_plates();
  ContourRequest request;
  request.measure = Measure::total;
  request.isolux = request.caustic = false;
  request.boundaries = true;
  const auto result = trace_contours(system, request);
  EXPECT_EQ(result.undecided_cells, 0u);
  LightMeter meter(system, {}, false);
  std::map<BoundaryKind, double> lengths;
  for (const Curve& c : result.curves) {
    EXPECT_EQ(c.kind, CurveKind::boundary);
    EXPECT_EQ(c.level, -1.0);
    EXPECT_EQ(c.family_id < 0, c.boundary == BoundaryKind::receiver);
    lengths[c.boundary] += c.length;
    if (c.boundary == BoundaryKind::receiver) continue;
    const auto &a = c.vertices[c.vertices.size() / 2 - 1], &b = c.vertices[c.vertices.size() / 2];
    const Vec2 along = (b.uv - a.uv).normalized(), left = 3e-6 * Vec2(-along.y(), along.x());
    EXPECT_NEAR(meter.at(b.uv + left).E, b.bright, 1e-5);
    EXPECT_NEAR(meter.at(b.uv - left).E, b.dark, 1e-5);
    EXPECT_GT(b.bright, b.dark);
  }
  EXPECT_NEAR(lengths[BoundaryKind::receiver], 12.0, 1e-9);
  EXPECT_GT(lengths[BoundaryKind::aperture], 4.0);
  EXPECT_EQ(lengths.size(), 2u);
}

TEST(TotalContours, OfOverlappingPatches) {
  const auto system = test::two_plates();
  const auto result = total_of(system, {0.05, 0.09, 0.12}, 3e-4);
  ASSERT_FALSE(result.unsupported) << *result.unsupported;
  EXPECT_EQ(result.undecided_cells, 0u);
  expect_closed_rings(result, 3.0);
  expect_true_of_the_meter(system, result);
  expect_areas(system, result, 3e-4);
}

TEST(TotalContours, OfOneDimensionalWaterAreStrips) {
  const auto system = test::water_waves(1.0);
  const auto result = total_of(system, {0.8, 1.5, 3.0}, 1e-4);
  ASSERT_FALSE(result.unsupported);
  EXPECT_EQ(result.undecided_cells, 0u);
  expect_closed_rings(result, 1.0);
  // The width of the strip from its ends on the line v = 0, by bisection of the meter's reading.
  LightMeter meter(system, {}, false);
  for (const double level : result.levels) {
    double ends[2];
    for (const int side : {0, 1}) {
      double dark = side == 0 ? -0.45 : 0.0, bright = -0.25 + (side == 0 ? -0.004 : 0.004);
      for (int k = 0; k < 50; ++k) {
        const double middle = 0.5 * (dark + bright);
        (meter.at({middle, 0.0}).E < level ? dark : bright) = middle;
      }
      ends[side] = bright;
    }
    EXPECT_NEAR(area_above(result, level), ends[1] - ends[0], 1e-8) << level;
  }
}

TEST(TotalContours, OfWavesInTwoDirections) {
  const auto system = test::crossing_waves();
  const auto result = total_of(system, {0.8, 1.5, 3.0}, 1e-4);
  EXPECT_EQ(result.undecided_cells, 0u);
  expect_closed_rings(result, 1.0);
  expect_true_of_the_meter(system, result);
  expect_areas(system, result, 1e-4);
}

TEST(TotalContours, OfATiltedDish) {
  const auto system = test::tilted_dish();
  const auto result = total_of(system, {2.0, 8.0, 40.0}, 6e-5);
  EXPECT_EQ(result.undecided_cells, 0u);
  expect_closed_rings(result, 0.6);
  expect_true_of_the_meter(system, result);
  expect_areas(system, result, 6e-5);
}

// Largest distance of `curves` from the polylines of `truth`, at vertices and in the middle
// between.
double farthest(const ContourResult& curves, const ContourResult& truth, double level) {
  double most = 0.0;
  for (const Curve& c : curves.curves) {
    if (c.level != level) continue;
    for (std::size_t i = 0; i + 1 < c.vertices.size(); ++i) {
      for (const double w : {0.0, 0.5}) {
        const Vec2 q = (1.0 - w) * c.vertices[i].uv + w * c.vertices[i + 1].uv;
        double least = geometry::kInfinity;
        for (const Curve& other : truth.curves) {
          if (other.level == level) least = std::min(least, test::distance_to(other, q));
        }
        most = std::max(most, least);
      }
    }
  }
  return most;
}

// Both ways, cusps, caustics and edges included.
TEST(TotalContours, KeepToTheChordEverywhere) {
  for (const auto& [system, levels] : {std::pair{test::nephroid_ring(), std::vector{1.0, 4.0}},
                                       std::pair{test::tilted_dish(), std::vector{2.0, 40.0}}}) {
    const double chord = 1e-3 * system.receiver().width();
    const auto coarse = total_of(system, levels, chord),
               fine = total_of(system, levels, 1e-2 * chord);
    for (const double level : levels) {
      EXPECT_LE(farthest(coarse, fine, level), 1.02 * chord) << level;
      EXPECT_LE(farthest(fine, coarse, level), 1.02 * chord) << level;
    }
  }
}

TEST(TotalContours, OfACuboid) {
  const auto system = test::cuboid_over_floor();
  const auto result = total_of(
      system, test::kSanitized ? std::vector{0.01} : std::vector{0.001, 0.003, 0.01}, 8e-4);
  EXPECT_EQ(result.undecided_cells, 0u);
  for (const auto& w : result.warnings) ADD_FAILURE() << w.code << w.detail;
  expect_closed_rings(result, 8.0);
  expect_true_of_the_meter(system, result);
  expect_areas(system, result, 8e-4, 2000);  // a reading takes a third of a millisecond
}

// A closed arc that keeps to within a coarse chord of a jump is drawn all the same.
TEST(TotalContours, OfACuboidCoarsely) {
  const auto system = test::cuboid_over_floor();
  const std::vector<double> levels{0.010316681617751924};
  const auto coarse = total_of(system, levels, 0.08), fine = total_of(system, levels, 8e-4);
  for (const auto& w : coarse.warnings) ADD_FAILURE() << w.code << w.detail;
  EXPECT_EQ(coarse.curves.size(), fine.curves.size());
  EXPECT_LE(farthest(coarse, fine, levels[0]), 0.08);
  EXPECT_LE(farthest(fine, coarse, levels[0]), 0.08);
}

TEST(TotalContours, OfATorus) {
  const auto system = test::torus_beside_lamp();
  const auto result = total_of(system, {0.001, 0.003, 0.01, 0.02}, 8e-4);
  ASSERT_FALSE(result.unsupported);
  EXPECT_EQ(result.undecided_cells, 0u);
  for (const auto& w : result.warnings) ADD_FAILURE() << w.code << w.detail;
  expect_closed_rings(result, 8.0);
  expect_true_of_the_meter(system, result);
  expect_areas(system, result, 8e-4);
}

OpticalSystem torus_over_floor(const Point& lamp) {
  return test::one_mirror(PointLight{lamp, 1.0},
                          geometry::make_torus({0, 0, 0.4}, {0, 0, 1}, 1.0, 0.35),
                          test::floor_at({0, 0, 0}, 8, 8));
}

// Sheets fade in so steeply beside its silhouette that arcs leave that hardly, and next to where
// the light that it hides from itself begins, what touches it moves fast.
TEST(TotalContours, OfATorusOverTheFloor) {
  for (const Point& lamp : {Point(1.6038, 0.8778, 3), Point(2.112, 0.4743, 3),
                            Point(1.1597, 0.4213, 3), Point(1.1868, 1.1011, 3)}) {
    const auto system = torus_over_floor(lamp);
    const auto result =
        total_of(system, {1e-4, 3.3e-4, 1.18e-3, 1.5653e-3, 3.8049e-3, 5.24457e-3}, 8e-4);
    for (const auto& w : result.warnings) ADD_FAILURE() << w.code << w.detail;
    expect_closed_rings(result, 8.0);
    expect_true_of_the_meter(system, result);
    if (test::kSanitized) break;
  }
}

// Where an edge is missed, as next to this torus, the answer says so and arcs do not run on beyond
// it: nothing is drawn off the receiver.
TEST(TotalContours, StayOnTheReceiver) {
  for (const Point& lamp : {Point(2.2672, 0.3021, 3.0), Point(2.0479, 1.117, 3.0)}) {
    const auto system = torus_over_floor(lamp);
    const double chord = 8e-4;
    const auto result = total_of(system, {0.0012055, 0.00123265}, chord);
    EXPECT_FALSE(result.curves.empty());
    for (const auto& curve : result.curves) {
      for (const auto& v : curve.vertices) EXPECT_LE(v.uv.cwiseAbs().maxCoeff(), 4.0 + chord);
    }
    if (test::kSanitized) break;
  }
}

}  // namespace
}  // namespace caustic::solver
