// Contours of the total irradiance: against the sheets where there is one, against all paths found
// anew, against areas by random points.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "geometry/expression/field.h"
#include "solver/contours.h"
#include "solver/point_irradiance.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace caustic::solver {
namespace {

using geometry::kPi;
using test::floor_at;
using test::one_mirror;
using test::Random;

// 10⁷ by ISOCAUSTIC_SAMPLES=10000000.
int sample_count() {
  const char* wanted = std::getenv("ISOCAUSTIC_SAMPLES");
  return wanted ? std::atoi(wanted) : 20000;
}

ContourResult total_of(const OpticalSystem& system, std::vector<double> levels,
                       double chord = 0.0) {
  ContourRequest request;
  request.measure = Measure::total;
  request.levels.values = std::move(levels);
  request.chord_tolerance = chord;
  request.time_limit = 60.0;
  return trace_contours(system, request);
}

OpticalSystem ball_under_ceiling() {
  return one_mirror(PointLight{{0, 0, 4}, 1.0}, geometry::make_sphere(Point::Zero(), 1.0),
                    floor_at({0, 0, 6}, 12, 12));
}

// Unit cylinder arc |φ| ≤ 60°, height 1, lit by a beam at 45° along x.
OpticalSystem nephroid_ring() {
  return one_mirror(CollimatedLight{Vec3(1, 0, -1).normalized(), 1.0},
                    geometry::make_cylinder(Point::Zero(), {0, 0, 1}, 1.0),
                    floor_at({0.5, 0, 0}, 1.2, 1.2),
                    geometry::box_aperture({0.5, -1, 0}, {1.001, 1, 1}));
}

// Two tilted plates whose patches of light overlap on the ceiling.
OpticalSystem two_plates() {
  auto left = test::mirror(geometry::make_plane({-0.5, 0, 0}, Vec3(0.2, 0, 1).normalized()),
                           geometry::box_aperture({-0.8, -0.3, -1}, {-0.2, 0.3, 1}), 0.9);
  auto right = test::mirror(geometry::make_plane({0.5, 0, 0}, Vec3(-0.2, 0.05, 1).normalized()),
                            geometry::box_aperture({0.2, -0.25, -1}, {0.8, 0.35, 1}), 0.8);
  right.name = "right";
  return OpticalSystem::build(PointLight{{0.1, 0.05, 1.0}, 1.0}, {left, right},
                              floor_at({0, 0, 1.5}, 3, 3));
}

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

double area_above(const ContourResult& result, double level) {
  double twice = 0.0;
  for (const Curve& c : result.curves) {
    if (c.level != level) continue;
    const std::size_t n = c.vertices.size();
    for (std::size_t i = 0; i < (c.closed ? n : n - 1); ++i) {
      const Vec2 &a = c.vertices[i].uv, &b = c.vertices[(i + 1) % n].uv;
      twice += a.x() * b.y() - a.y() * b.x();
    }
  }
  return 0.5 * twice;
}

// Every arc begins where the one before it in its ring ends.
void expect_closed_rings(const ContourResult& result, double width) {
  std::map<int, std::map<int, const Curve*>> rings;
  for (const Curve& c : result.curves) {
    if (c.kind == CurveKind::caustic) continue;
    EXPECT_EQ(c.family_id, -1);
    EXPECT_EQ(c.parity, 0);
    EXPECT_TRUE(rings[c.ring_id].emplace(c.ring_order, &c).second);
  }
  for (const auto& [id, arcs] : rings) {
    if (arcs.size() == 1 && arcs.begin()->second->closed) continue;
    for (const auto& [order, arc] : arcs) {
      ASSERT_FALSE(arc->closed);
      EXPECT_EQ(arc->ends, (std::vector{Ending::node, Ending::node}));
      const int next = (order + 1) % static_cast<int>(arcs.size());
      ASSERT_TRUE(arcs.contains(next)) << "ring " << id;
      EXPECT_LT((arcs.at(next)->vertices.front().uv - arc->vertices.back().uv).norm(), 1e-7 * width)
          << "ring " << id << " after arc " << order;
    }
  }
}

// Level arcs and jumps against what a meter reads there, all paths found anew.
void expect_true_of_the_meter(const OpticalSystem& system, const ContourResult& result) {
  LightMeter meter(system, {}, false);
  const double step = 1e-6 * system.receiver().width();
  int arcs = 0, jumps = 0;
  for (const Curve& c : result.curves) {
    if (c.kind == CurveKind::caustic || c.kind == CurveKind::receiver_edge) continue;
    const std::size_t n = c.vertices.size();
    for (std::size_t i = 1; i + 1 < n; i += std::max<std::size_t>(1, n / 7)) {
      const CurveVertex& v = c.vertices[i];
      const Vec2 along = (c.vertices[i + 1].uv - c.vertices[i - 1].uv).normalized();
      const Vec2 left(-along.y(), along.x());
      if (c.kind == CurveKind::isolux) {
        const auto reading = meter.at(v.uv);
        EXPECT_NEAR(reading.E / c.level, 1.0, 1e-8) << v.uv.transpose();
        EXPECT_LT((reading.gradient - v.gradient).norm(), 1e-6 * v.gradient.norm());
        const Vec2 g(system.receiver().u.dot(v.gradient), system.receiver().v.dot(v.gradient));
        EXPECT_GT(g.dot(left), 0.0);
        EXPECT_LT(v.residual, 1e-9);
        ++arcs;
        continue;
      }
      EXPECT_LT(v.dark, c.level);
      EXPECT_TRUE(v.bright == -1.0 || v.bright >= c.level);
      // Both sides, as far as the totals change over the step.
      const auto dark = meter.at(v.uv - step * left), bright = meter.at(v.uv + step * left);
      const double slack =
          1e-3 * c.level +
          10.0 * step * (dark.gradient.norm() + (v.bright < 0.0 ? 0.0 : bright.gradient.norm()));
      EXPECT_NEAR(dark.E, v.dark, slack) << v.uv.transpose();
      if (v.bright >= 0.0)
        EXPECT_NEAR(bright.E, v.bright, slack) << v.uv.transpose();
      else
        EXPECT_TRUE(bright.on_caustic || bright.E > c.level);
      ++jumps;
    }
  }
  EXPECT_GT(arcs, 4);
  EXPECT_GT(jumps, 4);
}

// By random points with the same seed: within four standard deviations.
void expect_areas(const OpticalSystem& system, const ContourResult& result, double chord) {
  LightMeter meter(system, {}, false);
  Random random(77);
  const Vec2 half = system.receiver().half;
  std::map<double, int> inside;
  const int samples = sample_count();
  for (int k = 0; k < samples; ++k) {
    const Vec2 q(random.uniform(-half.x(), half.x()), random.uniform(-half.y(), half.y()));
    const auto reading = meter.at(q);
    for (const double level : result.levels)
      inside[level] += reading.on_caustic || reading.E >= level;
  }
  const double all = 4.0 * half.x() * half.y();
  for (const double level : result.levels) {
    const double share = inside[level] / double(samples);
    const double noise = std::sqrt(std::max(share * (1.0 - share), 1.0 / samples) / samples);
    double length = 0.0;
    for (const Curve& c : result.curves) length += c.level == level ? c.length : 0.0;
    EXPECT_NEAR(area_above(result, level), share * all, 4.0 * noise * all + length * chord)
        << level;
  }
}

TEST(TotalContours, OfOneSheetAreTheSheets) {
  const auto system = ball_under_ceiling();
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

// A coarse polyline may pass points of the grid on the wrong side; its arc is not traced again.
TEST(TotalContours, DrawnCoarselyAreDrawnOnce) {
  const auto system = ball_under_ceiling();
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
  const auto system = nephroid_ring();
  const auto result = total_of(system, {1.0, 2.0, 4.0}, 1.2e-4);
  ASSERT_FALSE(result.unsupported);
  EXPECT_EQ(result.undecided_cells, 0u);
  EXPECT_TRUE(result.warnings.empty());
  expect_closed_rings(result, 1.2);
  expect_true_of_the_meter(system, result);
  expect_areas(system, result, 1.2e-4);
}

TEST(TotalContours, OfOverlappingPatches) {
  const auto system = two_plates();
  const auto result = total_of(system, {0.05, 0.09, 0.12}, 3e-4);
  ASSERT_FALSE(result.unsupported) << *result.unsupported;
  EXPECT_EQ(result.undecided_cells, 0u);
  expect_closed_rings(result, 3.0);
  expect_areas(system, result, 3e-4);
}

TEST(TotalContours, OfOneDimensionalWaterAreStrips) {
  const auto surface =
      geometry::make_expression(geometry::read_expression("z-0.1*sin(6.283185307179586*x)", 1.0),
                                {Point(-1, -1, -0.2), Point(2, 2, 0.2)}, {});
  auto water = test::mirror(surface.surface);
  water.optics = {.kind = Optics::Kind::refract, .index_outside = 1.0, .index_inside = 1.33};
  const auto system = OpticalSystem::build(CollimatedLight{{0, 0, -1}, 1.0}, {water},
                                           floor_at({0.5, 0.5, -1}, 1, 1));
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

TEST(TotalContours, OfATorus) {
  const auto system = one_mirror(PointLight{{3, 0, 2}, 1.0},
                                 geometry::make_torus(Point::Zero(), {0, 0, 1}, 1.5, 0.5),
                                 floor_at({0, 0, 4}, 8, 8));
  const auto result = total_of(system, {0.001, 0.003, 0.01, 0.02}, 8e-4);
  ASSERT_FALSE(result.unsupported);
  EXPECT_EQ(result.undecided_cells, 0u);
  for (const auto& w : result.warnings) ADD_FAILURE() << w.code << w.detail;
  expect_closed_rings(result, 8.0);
  expect_true_of_the_meter(system, result);
  expect_areas(system, result, 8e-4);
}

TEST(TotalContours, WhereLightIsHiddenAreLeftToALaterVersion) {
  const auto system =
      OpticalSystem::build(PointLight{{0, 0, 4}, 1.0},
                           {test::mirror(geometry::make_sphere(Point::Zero(), 1.0)),
                            test::absorber(geometry::make_sphere({1.5, 0, 3}, 0.5))},
                           floor_at({0, 0, 6}, 12, 12));
  const auto result = total_of(system, {3e-4});
  EXPECT_TRUE(result.unsupported);
  EXPECT_TRUE(result.curves.empty());
}

}  // namespace
}  // namespace caustic::solver
