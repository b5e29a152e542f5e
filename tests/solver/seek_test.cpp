// Small things behind mirrors: they are found however small, at a cost that grows with the
// logarithm of their size only.
#include "solver/seek.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>

#include "solver/point_irradiance.h"
#include "tests/support/scenes.h"

namespace caustic::solver {
namespace {

using test::floor_at;

TEST(Between, ByHowRaysPass) {
  const auto at = [](double x, double y) { return NearMiss{1, {x, y, 0.0}, {0.0, 0.0, 2.0}}; };
  const auto box = geometry::Box::around({0.03, 0.02, 5.0}, 0.01);
  const auto about = [&](double x, double y, double half) {
    const std::array rays{at(x - half, y - half), at(x + half, y - half), at(x + half, y + half),
                          at(x - half, y + half)};
    return between(rays, at(x, y), box);
  };
  EXPECT_EQ(about(0, 0, 0.1), Between::perhaps);
  EXPECT_EQ(about(1, 0, 0.1), Between::nothing);
  EXPECT_EQ(about(0.03, 0.02, 0.001), Between::dense);
  const std::array mixed{at(0, 0), NearMiss{2, {0, 0, 0}, {0, 0, 1}}};
  EXPECT_EQ(between(mixed, mixed[0], box), Between::mixed);
  // Rays that have passed it.
  const std::array back{NearMiss{1, {0, 0, 9}, {0, 0, 1}}, NearMiss{1, {0.1, 0, 9}, {0, 0, 1}}};
  EXPECT_EQ(between(back, back[0], box), Between::nothing);
}

// A ball of radius r one metre behind a plane mirror, which is 100 m wide or unbounded: a mirrored
// lamp over the ball. Its light comes back over the mirror to a receiver beside it.
struct BallAndMirror {
  Point lamp{0.3, -0.2, 1.5}, middle;
  geometry::ReceiverFrame receiver = floor_at({0.9, 0.4, 1.2}, 0.5, 0.5);
  SystemSurface plane, ball;
  BallAndMirror(double r, bool unbounded) : middle(0.1, 0.15, 1.0) {
    const auto shape = geometry::make_plane(Point::Zero(), {0, 0, 1});
    plane = unbounded ? test::mirror(shape)
                      : test::mirror(shape, geometry::box_aperture({-50, -50, -1}, {50, 50, 1}));
    plane.name = "plane";
    ball = test::mirror(geometry::make_sphere(middle, r));
  }
  OpticalSystem system() const {
    return OpticalSystem::build(PointLight{lamp, 1.0}, {plane, ball}, receiver);
  }
  OpticalSystem alone() const {
    return OpticalSystem::build(PointLight{{lamp.x(), lamp.y(), -lamp.z()}, 1.0}, {ball}, receiver);
  }
};

TEST(Seek, SmallBallBehindALargeMirror) {
  for (const bool unbounded : {false, true}) {
    std::uint64_t largest = 0;
    for (const double r : {1e-1, 1e-3, 1e-5}) {
      SCOPED_TRACE(testing::Message() << "radius " << r << (unbounded ? " unbounded" : ""));
      const BallAndMirror scene(r, unbounded);
      const auto system = scene.system();
      ContourRequest request;
      request.families = {{0, 1}};
      request.levels.count = 4;
      const auto found = trace_contours(system, request);
      EXPECT_EQ(found.undecided_cells, 0u);
      ContourRequest same;
      same.levels.values = found.levels;
      const auto expected = trace_contours(scene.alone(), same);
      ASSERT_EQ(found.curves.size(), expected.curves.size());
      ASSERT_FALSE(found.curves.empty());
      LightMeter meter(system, {{0, 1}}, false);
      for (std::size_t i = 0; i < found.curves.size(); ++i) {
        const Curve& c = found.curves[i];
        EXPECT_NEAR(c.length, expected.curves[i].length, 1e-3 * c.length);
        const PointIrradiance at = meter.at(c.vertices[c.vertices.size() / 2].uv);
        EXPECT_EQ(at.sheets.size(), 1u);
        EXPECT_NEAR(at.E / c.level, 1.0, 1e-5);  // rounding of x against the ball's radius
      }
      EXPECT_NEAR(found.families[0].flux, expected.families[0].flux,
                  1e-3 * expected.families[0].flux);
      if (largest == 0) largest = found.evaluations;
      EXPECT_LE(found.evaluations, largest + largest / 2);
    }
  }
}

}  // namespace
}  // namespace caustic::solver
