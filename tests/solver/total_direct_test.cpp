// Contours of the total with the light that comes straight from the source: shadows in closed form,
// mirrors that are plane by the lamp's image, balls by a light meter that searches paths.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "tests/support/scenes.h"
#include "tests/support/thorough.h"
#include "tests/support/total_checks.h"

namespace caustic::solver {
namespace {

using geometry::box_aperture;
using geometry::kPi;
using geometry::make_plane;
using geometry::make_sphere;
using test::absorber;
using test::area_above;
using test::expect_areas;
using test::expect_closed_rings;
using test::expect_true_of_the_meter;
using test::floor_at;
using test::mirror;
using test::one_mirror;
using test::total_of;

// Random points for an area.
constexpr int kDirectPoints = test::thorough(5000, 500);

// Of a lamp of 1 W/sr at a on the floor z = 0.
double lamp_at(const Point& a, const Vec2& q) {
  return std::abs(a.z()) / std::pow((Point(q.x(), q.y(), 0.0) - a).norm(), 3);
}

void expect_settled(const ContourResult& result) {
  EXPECT_FALSE(result.unsupported);
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(result.undecided_cells, 0u);
  for (const auto& w : result.warnings) ADD_FAILURE() << w.code << ' ' << w.detail;
}

// Every vertex of a level arc but its ends, which lie on boundaries, and how many jumps there are.
int expect_level_arcs(const ContourResult& result, const test::TotalAt& total) {
  int jumps = 0;
  for (const Curve& c : result.curves) {
    jumps += c.kind == CurveKind::jump;
    if (c.kind != CurveKind::isolux) continue;
    for (std::size_t i = 1; i + 1 < c.vertices.size(); ++i)
      EXPECT_NEAR(total(c.vertices[i].uv) / c.level, 1.0, 1e-9);
  }
  return jumps;
}

// An absorber of radius 0.2 about (0.3, 0, 0.8) under a lamp at height 2: the shadow is an ellipse.
TEST(DirectLight, LeavesTheShadowOfABall) {
  const Point lamp(0, 0, 2), center(0.3, 0, 0.8);
  const double radius = 0.2;
  const auto system =
      OpticalSystem::build(PointLight{lamp, 1.0}, {absorber(make_sphere(center, radius))},
                           floor_at(Point::Zero(), 4, 4));
  const Vec3 axis = (center - lamp).normalized();
  const double sine = radius / (center - lamp).norm(), cosine = std::sqrt(1.0 - sine * sine);
  const auto off = [&](const Vec2& q) {  // of the cone of shadow, < 0 inside
    const Vec3 d = Point(q.x(), q.y(), 0.0) - lamp;
    return cosine - axis.dot(d.normalized());
  };
  const auto total = [&](const Vec2& q) { return off(q) < 0.0 ? 0.0 : lamp_at(lamp, q); };
  const auto result = total_of(system, {0.05, 0.12, 0.2}, 4e-4, true);
  expect_settled(result);
  EXPECT_GT(expect_level_arcs(result, total), 1);
  expect_closed_rings(result, 4.0);
  for (const Curve& c : result.curves) {
    if (c.kind != CurveKind::jump) continue;
    EXPECT_EQ(c.boundary, BoundaryKind::shadow);
    for (const CurveVertex& v : c.vertices) {
      EXPECT_NEAR(off(v.uv), 0.0, 1e-9);
      EXPECT_EQ(v.dark, 0.0);
      EXPECT_NEAR(v.bright / lamp_at(lamp, v.uv), 1.0, 1e-9);
    }
  }
  expect_areas(system, result, 4e-4, total, kDirectPoints);
}

// A plane mirror x = 1 with this rectangle, and what blocks.
const Point kLampByPlate(0, 0, 1.5);
OpticalSystem floor_by_plate(double bottom) {
  return one_mirror(PointLight{kLampByPlate, 1.0}, make_plane({1, 0, 0}, {1, 0, 0}),
                    floor_at(Point::Zero(), 4, 4),
                    box_aperture({0.5, -0.6, bottom}, {1.5, 0.6, 1.1}), 0.8);
}
double total_by_plate(double bottom, const Vec2& q) {
  const auto on_plate = [&](const Point& from) {
    const Vec3 way = Point(q.x(), q.y(), 0.0) - from;
    const double t = (1.0 - from.x()) / way.x();
    const Point y = from + t * way;
    return t > 0.0 && t < 1.0 && std::abs(y.y()) < 0.6 && y.z() > bottom && y.z() < 1.1;
  };
  const Point image(2.0 - kLampByPlate.x(), kLampByPlate.y(), kLampByPlate.z());
  const double direct = q.x() > 1.0 && on_plate(kLampByPlate) ? 0.0 : lamp_at(kLampByPlate, q);
  return direct + (q.x() < 1.0 && on_plate(image) ? 0.8 * lamp_at(image, q) : 0.0);
}

void expect_right_by_plate(double bottom) {
  const auto system = floor_by_plate(bottom);
  const auto total = [=](const Vec2& q) { return total_by_plate(bottom, q); };
  const auto result = total_of(system, {0.1, 0.25, 0.4}, 4e-4, true);
  expect_settled(result);
  EXPECT_GT(expect_level_arcs(result, total), 4);
  expect_closed_rings(result, 4.0);
  expect_true_of_the_meter(system, result, true);
  expect_areas(system, result, 4e-4, total, kDirectPoints);
}

TEST(DirectLight, AddsToThatOfAPlateBesideIt) { expect_right_by_plate(0.2); }

// There the direct light ends in front of the plate just where the light of the mirror begins, and
// behind it nothing is.
TEST(DirectLight, AddsToThatOfAPlateOnTheFloor) { expect_right_by_plate(0.0); }

void expect_right_by_meter(const OpticalSystem& system, const std::vector<double>& levels,
                           double chord) {
  const auto result = total_of(system, levels, chord, true);
  expect_settled(result);
  expect_closed_rings(result, system.receiver().width());
  expect_true_of_the_meter(system, result, true);
  expect_areas(system, result, chord, kDirectPoints, true);
}

OpticalSystem over_floor(std::vector<SystemSurface> surfaces) {
  for (SystemSurface& s : surfaces) s.name += std::to_string(&s - surfaces.data());
  return OpticalSystem::build(PointLight{{0, 0, 2.5}, 1.0}, std::move(surfaces),
                              floor_at(Point::Zero(), 4, 4));
}

// The silhouette is the edge of the shadow, and what is reflected fades in at it.
TEST(DirectLight, EndsWhereAMirrorBallBegins) {
  expect_right_by_meter(over_floor({mirror(make_sphere({0.2, 0.1, 0.9}, 0.4))}),
                        {0.04, 0.12, 0.165}, 4e-4);
}

TEST(DirectLight, EndsWhereABallTouchesTheFloorOrIsSunkInIt) {
  for (const double height : {0.4, 0.25})
    expect_right_by_meter(over_floor({mirror(make_sphere({0.7, 0.1, height}, 0.4))}),
                          {0.04, 0.12, 0.17}, 4e-4);
  // Of a half ball what touches rays and where it meets the floor are tangent to each other.
  expect_right_by_meter(over_floor({absorber(make_sphere({0.7, 0.1, 0.0}, 0.4))}),
                        {0.04, 0.12, 0.155}, 4e-4);
}

TEST(DirectLight, EndsWhereShadowsOverlap) {
  expect_right_by_meter(over_floor({mirror(make_sphere({0.2, 0.1, 0.9}, 0.4)),
                                    absorber(make_sphere({0.5, -0.1, 1.2}, 0.3)),
                                    absorber(make_plane({-0.3, 0, 0.5}, {0, 0, 1}),
                                             box_aperture({-0.8, -0.3, 0}, {0.1, 0.2, 1}))}),
                        {0.04, 0.12, 0.165}, 4e-4);
}

// A half ball shows its inside too.
TEST(DirectLight, EndsWhereAShellBegins) {
  expect_right_by_meter(over_floor({mirror(make_sphere({0.6, 0.1, 0.9}, 0.4),
                                           box_aperture({0, -1, 0.8}, {2, 1, 2}))}),
                        {0.04, 0.12, 0.165}, 4e-4);
}

// Within a mirror sphere that the floor cuts light arrives at the cut by several ways, and all of
// them end there.
TEST(DirectLight, EndsWithAllSheetsWhereASphereMeetsTheFloor) {
  const auto system = OpticalSystem::build(PointLight{{0.1, 0.05, -0.65}, 1.0},
                                           {mirror(make_sphere({0, 0, -0.6}, 1.0), {}, 0.8)},
                                           floor_at(Point::Zero(), 2, 2));
  expect_right_by_meter(system, {1.5, 3.0, 6.0}, 4e-4);
  const auto mirrored = total_of(system, {1.0, 3.0}, 4e-4);
  expect_settled(mirrored);
  expect_closed_rings(mirrored, 2.0);
  expect_true_of_the_meter(system, mirrored);
  expect_areas(system, mirrored, 4e-4, kDirectPoints);
}

// A cap a little above the middle of its ball: where the rim takes over from what touches rays,
// both are nearly one.
TEST(DirectLight, EndsWhereARimIsNearlyASilhouette) {
  expect_right_by_meter(
      OpticalSystem::build(PointLight{{0.05, -0.32, 2.52}, 1.0},
                           {mirror(make_sphere({0.1, -0.51, 1.19}, 0.27),
                                   box_aperture({-1, -2, 1.21}, {1, 1, 2}), 0.63)},
                           floor_at(Point::Zero(), 4, 4)),
      {0.057, 0.091, 0.133, 0.15}, 4e-4);
}

// A plate seen nearly from its edge, whose shadow is a sliver a hundredth wide.
TEST(DirectLight, LeavesASliver) {
  const Point lamp(0.715, 0.797, 2.853), on(-0.6817, 0.9896, 0.6717);
  const Vec3 normal = Vec3(0.2616, -0.9316, -0.2256).normalized();
  const auto system = OpticalSystem::build(
      PointLight{lamp, 1.0},
      {absorber(make_plane(on, normal),
                box_aperture({-0.785, 0.8687, 0.5206}, {-0.5125, 1.1719, 1.005}))},
      floor_at(Point::Zero(), 4, 4));
  const auto result = total_of(system, {0.02}, 1e-5, true);
  expect_settled(result);
  expect_closed_rings(result, 4.0);
  // The plate's corners, on four edges of its box, as the lamp throws them.
  double twice = 0.0;
  std::vector<Vec2> corners;
  for (const auto& [x, z] :
       {std::pair{-0.785, 0.5206}, {-0.785, 1.005}, {-0.5125, 1.005}, {-0.5125, 0.5206}}) {
    const double y = on.y() - (normal.x() * (x - on.x()) + normal.z() * (z - on.z())) / normal.y();
    const Vec3 d = Point(x, y, z) - lamp;
    corners.push_back((lamp - lamp.z() / d.z() * d).head<2>());
  }
  for (std::size_t i = 0; i < 4; ++i) twice += geometry::cross(corners[i], corners[(i + 1) % 4]);
  EXPECT_GT(std::abs(twice), 1e-4);
  EXPECT_NEAR(area_above(result, 0.02), 16.0 - 0.5 * std::abs(twice), 1e-6);
}

// The direct light is even, so levels just above it are curves of what a far ball adds, a
// thousandth.
TEST(DirectLight, OfABeamHidesNoLevelOfWhatIsFaint) {
  const Vec3 beam = Vec3(-0.6, -0.4, -1).normalized();
  const auto system = OpticalSystem::build(CollimatedLight{beam, 0.2},
                                           {mirror(make_sphere({0.97, 0.92, 1.13}, 0.1), {}, 0.94)},
                                           floor_at(Point::Zero(), 4, 4));
  const double even = -0.2 * beam.z();
  const auto result = total_of(system, {1.0002 * even, 1.0006 * even, 1.001 * even}, 4e-4, true);
  expect_settled(result);
  expect_closed_rings(result, 4.0);
  expect_areas(system, result, 4e-4, kDirectPoints, true);
}

// A window into water: above its surface the lamp itself, below what is refracted.
TEST(DirectLight, GoesOnBelowWaterAsItsSheet) {
  auto water = mirror(make_plane(Point::Zero(), {0, 0, 1}), box_aperture({-9, -9, -1}, {9, 9, 1}));
  water.optics = {Optics::Kind::refract, 1.0, {}, 1.0, 1.33, true};
  const auto wall = geometry::ReceiverFrame::make({-1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 2});
  expect_right_by_meter(OpticalSystem::build(PointLight{{0.5, 0.1, 0.6}, 1.0}, {water}, wall),
                        {0.1, 0.2, 0.3}, 2e-4);
}

// Where a slope of water ends on the floor what comes out of it is brighter than the lamp in it.
TEST(DirectLight, GoesOnBrighterOutOfWater) {
  const double slope = 40.0 * kPi / 180.0;
  auto water = mirror(make_plane(Point::Zero(), {std::sin(slope), 0, std::cos(slope)}),
                      box_aperture({-9, -9, -9}, {9, 9, 9}));
  water.optics = {Optics::Kind::refract, 1.0, {}, 1.33, 1.0, false};
  expect_right_by_meter(OpticalSystem::build(PointLight{{0.2, 0.1, 1.5}, 1.0}, {water},
                                             floor_at(Point::Zero(), 2, 2)),
                        {0.3, 0.48, 0.55}, 2e-4);
}

// A plate of 0.3 by 0.5 across a slanted beam, and a speck: the areas of their shadows.
TEST(DirectLight, LeavesShadowsOfABeam) {
  const Vec3 beam = Vec3(0.3, -0.2, -1).normalized();
  const auto plate =
      absorber(make_plane({0, 0, 1}, {0, 0, 1}), box_aperture({0, 0, 0}, {0.3, 0.5, 2}));
  auto speck = absorber(make_sphere({-0.7, 0.3, 0.4}, 1e-3));
  speck.name = "speck";
  const auto system = OpticalSystem::build(CollimatedLight{beam, 10.0}, {plate, speck},
                                           floor_at(Point::Zero(), 4, 4));
  const auto result = total_of(system, {9.0}, 1e-6, true);
  expect_settled(result);
  expect_closed_rings(result, 4.0);
  EXPECT_NEAR(area_above(result, 9.0), 16.0 - 0.15 - kPi * 1e-6 / -beam.z(), 1e-8);
  const auto none = total_of(system, {9.5}, 1e-6, true);
  EXPECT_TRUE(none.curves.empty());
}

// In its own plane a lamp is dark; from below it counts as from above.
TEST(DirectLight, ComesFromEitherSide) {
  const auto beside = absorber(make_sphere({9, 0, 0.5}, 0.2));
  const auto area_of = [&](double height) {
    const auto system = OpticalSystem::build(PointLight{{0, 0, height}, 1.0}, {beside},
                                             floor_at(Point::Zero(), 4, 4));
    const auto result = total_of(system, {0.5}, 1e-5, true);
    expect_settled(result);
    return area_above(result, 0.5);
  };
  const double r2 = std::pow(2.0, 2.0 / 3.0) - 1.0;  // (1 + r²)^(−3/2) = ½
  EXPECT_NEAR(area_of(1.0), kPi * r2, 1e-4);
  EXPECT_NEAR(area_of(-1.0), kPi * r2, 1e-4);
  EXPECT_EQ(area_of(0.0), 0.0);
}

}  // namespace
}  // namespace caustic::solver
