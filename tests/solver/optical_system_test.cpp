#include "solver/optical_system.h"

#include <gtest/gtest.h>

namespace caustic::solver {
namespace {

using namespace geometry;

std::vector<Bound> bounds_after_build(SurfacePtr shape, std::vector<Bound> bounds) {
  const auto receiver = ReceiverFrame::make({0, 0, 9}, {1, 0, 0}, {0, 1, 0}, {2, 2});
  return OpticalSystem::build(PointLight{{0, 0, 5}, 1.0},
                              {{"m", std::move(shape), std::move(bounds), {}, {}}}, receiver)
      .surfaces()[0]
      .bounds;
}

TEST(OpticalSystem, BoundsThatCutNothingOffAreDropped) {
  // Of a box about a unit sphere's cap the bottom and the sides cut, the lid in z = 3 does not.
  const auto sphere = make_sphere({0, 0, 0}, 1.0);
  const auto cap = bounds_after_build(sphere, box_aperture({-0.3, -0.2, 0.5}, {0.3, 0.2, 3.0}));
  EXPECT_EQ(cap.size(), 5u);
  for (const Bound& b : cap) EXPECT_NE(b.axis.z(), 1.0);
  EXPECT_TRUE(exists_at(cap, {0, 0, 1}));
  EXPECT_FALSE(exists_at(cap, {0, 0, -1}));

  EXPECT_TRUE(bounds_after_build(sphere, {cylinder_aperture({0, 0, 0}, {0, 0, 1}, 1.5)}).empty());
  EXPECT_EQ(bounds_after_build(sphere, {cylinder_aperture({0, 0, 0}, {0, 0, 1}, 0.9)}).size(), 1u);
  // Of two alike one is enough, and an aperture that admits nothing still does.
  const Bound half = half_space_aperture({0, 0, 0}, {0, 0, 1});
  EXPECT_EQ(bounds_after_build(sphere, {half, half}).size(), 1u);
  const auto none = bounds_after_build(sphere, box_aperture({5, 5, 5}, {6, 6, 6}));
  EXPECT_FALSE(exists_at(none, {1, 0, 0}) || exists_at(none, {0, 1, 0}) ||
               exists_at(none, {0, 0, 1}));
}

// Where the shape itself ends its surface goes on beyond, though its box does not.
TEST(OpticalSystem, AShapeKeepsItsOwnEnds) {
  const auto tube = make_revolution({0, 0, 0}, {0, 0, 1}, 2.0, {1.0, 0.1}).surface;
  const Bound lid = half_space_aperture({0, 0, 3}, {0, 0, 1});
  const auto bounds = bounds_after_build(tube, {lid});
  ASSERT_EQ(bounds.size(), 2u);
  for (const Bound& b : bounds) EXPECT_EQ(b.origin, Bound::Origin::shape);
  EXPECT_FALSE(exists_at(bounds, {1.2, 0, 2.1}) || exists_at(bounds, {1, 0, -0.1}));
}

TEST(OpticalSystem, AnUnboundedShapeKeepsWhatBoundsIt) {
  const auto paraboloid = make_conic({0, 0, 0}, {0, 0, 1}, 2.0, -1.0, {});
  EXPECT_EQ(
      bounds_after_build(paraboloid, {cylinder_aperture({0, 0, 0}, {0, 0, 1}, 1.0)})[0].radius,
      1.0);
  const auto clipped = bounds_after_build(make_plane({0, 0, 0}, {0, 0, 1}), {});
  ASSERT_EQ(clipped.size(), 1u);
  EXPECT_EQ(clipped[0].origin, Bound::Origin::clip);
}

}  // namespace
}  // namespace caustic::solver
