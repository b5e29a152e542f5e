// Contours of the total irradiance where surfaces hide light: edges of shadows and of what is
// occluded as jumps, against the lamp's mirror image and blockers written out here.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/scenes.h"
#include "tests/support/total_checks.h"

namespace caustic::solver {
namespace {

using geometry::box_aperture;
using geometry::make_plane;
using geometry::make_sphere;
using test::absorber;
using test::expect_areas;
using test::expect_closed_rings;
using test::expect_true_of_the_meter;
using test::floor_at;
using test::total_of;

const Point kLamp(0.1, 0.05, 1.5);
constexpr double kReceiverHeight = 2.0;  // of the receiver above the mirror z = 0, |x|, |y| ≤ 1

OpticalSystem above_mirror(std::vector<SystemSurface> blockers) {
  std::vector<SystemSurface> surfaces{
      test::mirror(make_plane({0, 0, 0}, {0, 0, 1}), box_aperture({-1, -1, -1}, {1, 1, 1}))};
  for (SystemSurface& blocker : blockers) {
    blocker.name += std::to_string(surfaces.size());
    surfaces.push_back(std::move(blocker));
  }
  return OpticalSystem::build(PointLight{kLamp, 1.0}, surfaces, floor_at({0, 0, kReceiverHeight}, 6, 6));
}

// E by the mirrored lamp; `blocks` says whether a segment is blocked.
template <class Blocks>
test::TotalAt by_image_of_lamp(const Blocks& blocks) {
  return [blocks](const Vec2& q) {
    const Point p(q.x(), q.y(), kReceiverHeight), image(kLamp.x(), kLamp.y(), -kLamp.z());
    const Vec3 way = p - image;
    const Point x = image + (kLamp.z() / way.z()) * way;
    if (std::abs(x.x()) > 1.0 || std::abs(x.y()) > 1.0) return 0.0;
    if (blocks(kLamp, x) || blocks(x, p)) return 0.0;
    return way.z() / std::pow(way.norm(), 3);
  };
}

bool meets_ball(const Point& a, const Point& b, const Point& center, double radius) {
  const Vec3 d = b - a;
  const double t = std::clamp(d.dot(center - a) / d.squaredNorm(), 0.0, 1.0);
  return (a + t * d - center).norm() < radius;
}

// The part of a plane in the box min … max.
bool meets_plate(const Point& a, const Point& b, const Point& on, const Vec3& normal,
                 const Point& min, const Point& max) {
  const double t = normal.dot(on - a) / normal.dot(b - a);
  if (!(t > 0.0 && t < 1.0)) return false;
  const Point y = a + t * (b - a);
  return (y.array() > min.array()).all() && (y.array() < max.array()).all();
}

void expect_right(const OpticalSystem& system, const test::TotalAt& total) {
  const auto result = total_of(system, {0.03, 0.05, 0.075}, 6e-4);
  EXPECT_EQ(result.undecided_cells, 0u);
  for (const auto& w : result.warnings) ADD_FAILURE() << w.code << w.detail;
  int jumps = 0;
  for (const Curve& c : result.curves) {
    jumps += c.boundary == BoundaryKind::shadow || c.boundary == BoundaryKind::occlusion;
    // The ends of arcs lie on the edges themselves.
    if (c.kind != CurveKind::isolux) continue;
    for (std::size_t i = 1; i + 1 < c.vertices.size(); ++i)
      EXPECT_NEAR(total(c.vertices[i].uv) / c.level, 1.0, 1e-9);
  }
  EXPECT_GT(jumps, 2);
  expect_closed_rings(result, 6.0);
  expect_true_of_the_meter(system, result);
  expect_areas(system, result, 6e-4, total);
}

TEST(TotalContours, BehindABallEndAtTouches) {
  const Point center(0.4, 0.1, 0.8);
  expect_right(above_mirror({absorber(make_sphere(center, 0.2))}),
               by_image_of_lamp(
                   [=](const Point& a, const Point& b) { return meets_ball(a, b, center, 0.2); }));
}

TEST(TotalContours, BehindAPlateEndAtRims) {
  const Point on(0.4, 0.1, 0.8), min(0.2, -0.2, 0), max(0.6, 0.3, 2);
  const Vec3 normal = Vec3(0.3, 0.1, 1).normalized();
  expect_right(above_mirror({absorber(make_plane(on, normal), box_aperture(min, max))}),
               by_image_of_lamp([=](const Point& a, const Point& b) {
                 return meets_plate(a, b, on, normal, min, max);
               }));
}

TEST(TotalContours, BehindTwoPlatesThatOverlap) {
  const Point on(0.4, 0.1, 0.8), min(0.2, -0.2, 0), max(0.6, 0.3, 2);
  const Point on2(0.4, 0.1, 0.9), min2(0.1, -0.05, 0), max2(0.7, 0.2, 2);
  const Vec3 normal = Vec3(0.3, 0.1, 1).normalized(), up(0, 0, 1);
  expect_right(above_mirror({absorber(make_plane(on, normal), box_aperture(min, max)),
                             absorber(make_plane(on2, up), box_aperture(min2, max2))}),
               by_image_of_lamp([=](const Point& a, const Point& b) {
                 return meets_plate(a, b, on, normal, min, max) ||
                        meets_plate(a, b, on2, up, min2, max2);
               }));
}

TEST(TotalContours, BehindACapEndAtTouchesAndRims) {
  const Point center(0.4, 0.1, 0.8);
  const auto blocks = [=](const Point& a, const Point& b) {
    // Both crossings of the sphere, of which only what is above z = 0.75 exists.
    const Vec3 d = b - a, m = a - center;
    const double dd = d.squaredNorm(), dm = d.dot(m);
    const double root = dm * dm - dd * (m.squaredNorm() - 0.25 * 0.25);
    if (root <= 0.0) return false;
    for (const double side : {-1.0, 1.0}) {
      const double t = (-dm + side * std::sqrt(root)) / dd;
      if (t > 0.0 && t < 1.0 && (a + t * d).z() > 0.75) return true;
    }
    return false;
  };
  expect_right(
      above_mirror({absorber(make_sphere(center, 0.25), box_aperture({0, -1, 0.75}, {2, 1, 2}))}),
      by_image_of_lamp(blocks));
}

TEST(TotalContours, WhereAWallStandsOnTheMirror) {
  const Point on(0.3, 0.1, 0.0), min(-1, -0.4, -1), max(1, 0.5, 0.4);
  const Vec3 normal = Vec3(1, 0.2, 0.3).normalized();
  expect_right(above_mirror({absorber(make_plane(on, normal), box_aperture(min, max))}),
               by_image_of_lamp([=](const Point& a, const Point& b) {
                 return meets_plate(a, b, on, normal, min, max);
               }));
}

// A torus hides what passes beside its hole, and shadows itself.
TEST(TotalContours, BehindATorus) {
  const auto ring =
      geometry::make_torus({0.3, 0.1, 0.8}, Vec3(0.3, 0.1, 1).normalized(), 0.2, 0.07);
  const auto system = above_mirror({absorber(ring)});
  const auto result = total_of(system, {0.03, 0.05, 0.075}, 6e-4);
  EXPECT_EQ(result.undecided_cells, 0u);
  expect_closed_rings(result, 6.0);
  expect_true_of_the_meter(system, result);
  expect_areas(system, result, 6e-4);
}

// A caustic passes behind a ball.
TEST(TotalContours, OfTheNephroidRingBehindABall) {
  const auto system =
      OpticalSystem::build(CollimatedLight{Vec3(1, 0, -1).normalized(), 1.0},
                           {test::mirror(geometry::make_cylinder(Point::Zero(), {0, 0, 1}, 1.0),
                                         box_aperture({0.5, -1, 0}, {1.001, 1, 1})),
                            absorber(make_sphere({0.45, 0.1, 0.35}, 0.1))},
                           floor_at({0.5, 0, 0}, 1.2, 1.2));
  const auto result = total_of(system, {1.0, 2.0, 4.0}, 1.2e-4);
  EXPECT_EQ(result.undecided_cells, 0u);
  expect_closed_rings(result, 1.2);
  expect_true_of_the_meter(system, result);
  expect_areas(system, result, 1.2e-4);
}

}  // namespace
}  // namespace caustic::solver
