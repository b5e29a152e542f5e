#include "geometry/aperture.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace caustic::geometry {
namespace {

using test::Random;

std::vector<Bound> bounds_of_each_kind(Random& random) {
  return {half_space_aperture(random.in_cube(1.0), random.direction()),
          cylinder_aperture(random.in_cube(1.0), random.direction(), random.uniform(0.3, 2.0)),
          ball(random.in_cube(1.0), random.uniform(0.3, 2.0), Bound::Origin::clip)};
}

// Signed distance to the boundary, positive outside, written without the program's formulas.
double outside_by(const Bound& b, const Point& x) {
  const Vec3 y = x - b.point;
  switch (b.kind) {
    case Bound::Kind::half_space: return y.dot(b.axis);
    case Bound::Kind::cylinder: return y.cross(b.axis).norm() - b.radius;
    case Bound::Kind::ball: return y.norm() - b.radius;
  }
  return 0.0;
}

TEST(Bound, SignGradientAndSlope) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    for (const Bound& b : bounds_of_each_kind(random)) {
      const Point x = random.in_cube(3.0);
      EXPECT_EQ(b.value(x) > 0.0, outside_by(b, x) > 0.0);
      const double h = 1e-3;
      for (int k = 0; k < 3; ++k) {
        const Vec3 e = h * Vec3::Unit(k);
        EXPECT_NEAR((b.value(x + e) - b.value(x - e)) / (2.0 * h), b.gradient(x)[k], 1e-10);
      }
      // Near its zero set the function is the distance.
      const Vec3 n = b.gradient(x).normalized();
      const Point edge = x - outside_by(b, x) * n;
      EXPECT_NEAR(b.value(edge), 0.0, 1e-14);
      EXPECT_NEAR(b.gradient(edge).norm(), 1.0, 1e-12);
      EXPECT_NEAR(b.value(edge + 1e-6 * n), 1e-6, 1e-11);
    }
  }
}

TEST(Bound, LargestInABoxIsReachedAndNeverExceeded) {
  Random random(5);
  for (int i = 0; i < 100; ++i) {
    for (const Bound& b : bounds_of_each_kind(random)) {
      const Point one = random.in_cube(2.0), other = random.in_cube(2.0);
      const Box box{one.cwiseMin(other), one.cwiseMax(other)};
      const double largest = b.largest_in(box);
      double sampled = -kInfinity;
      for (int k = 0; k < 1000; ++k) {
        Point x;
        for (int c = 0; c < 3; ++c) {
          const double w = random.uniform();
          x[c] = k % 2 ? (w < 0.5 ? box.min[c] : box.max[c])
                       : box.min[c] + w * (box.max[c] - box.min[c]);
        }
        sampled = std::max(sampled, b.value(x));
      }
      EXPECT_NEAR(sampled, largest, 1e-12);
    }
  }
}

TEST(Bound, LowerBoundIsOne) {
  Random random(2);
  for (int i = 0; i < 300; ++i) {
    for (const Bound& b : bounds_of_each_kind(random)) {
      const Point x = random.in_cube(3.0);
      const double r = random.log_uniform(1e-3, 3.0);
      const double bound = b.lower_bound_within(b.value(x), r);
      double least = kInfinity;
      for (int k = 0; k < 100; ++k) {
        const Point y = x + r * (k < 50 ? 1.0 : random.uniform()) * random.direction();
        least = std::min(least, b.value(y));
      }
      // Straight inwards it is attained.
      const double inwards = std::min(r, b.kind == Bound::Kind::half_space
                                             ? r : outside_by(b, x) + b.radius);
      least = std::min(least, b.value(x - inwards * b.gradient(x).normalized()));
      EXPECT_LE(bound, least + 1e-12);
      EXPECT_NEAR(bound, least, 1e-12);
    }
  }
}

TEST(ExistsAt, BoxCylinderAndSlack) {
  const auto box = box_aperture({-1, -2, -3}, {1, 2, 3});
  ASSERT_EQ(box.size(), 6u);
  Random random(3);
  const Box same{{-1, -2, -3}, {1, 2, 3}};
  for (int i = 0; i < 1000; ++i) {
    const Point x = random.in_cube(4.0);
    EXPECT_EQ(exists_at(box, x), same.contains(x));
  }
  EXPECT_TRUE(exists_at(box, {1, 2, 3}));
  EXPECT_FALSE(exists_at(box, {1.001, 0, 0}));
  EXPECT_TRUE(exists_at(box, {1.001, 0, 0}, 0.01));
  EXPECT_FALSE(exists_at(box, {0.999, 0, 0}, -0.01));
  EXPECT_TRUE(exists_at({}, {9, 9, 9}));
}

TEST(BoxOf, ContainsWhatExists) {
  Random random(4);
  for (int i = 0; i < 300; ++i) {
    std::vector<Bound> bounds;
    for (const Bound& b : bounds_of_each_kind(random)) {
      if (random.index(2) == 0) bounds.push_back(b);
    }
    if (random.index(2) == 0) bounds.push_back(cylinder_aperture(random.in_cube(1.0), {0, 1, 0}, 0.8));
    if (random.index(2) == 0) bounds.push_back(half_space_aperture(random.in_cube(1.0), {0, 0, -1}));
    const Box box = box_of(bounds);
    for (int k = 0; k < 200; ++k) {
      const Point x = random.in_cube(3.0);
      EXPECT_TRUE(!exists_at(bounds, x) || box.contains(x));
    }
  }
  const Box box = box_of(box_aperture({-1, -2, -3}, {1, 2, 3}));
  EXPECT_EQ(box.min, Point(-1, -2, -3));
  EXPECT_EQ(box.max, Point(1, 2, 3));
  EXPECT_TRUE(box_of({ball({1, 1, 1}, 2.0, Bound::Origin::clip)}).bounded());
  EXPECT_FALSE(box_of({}).bounded());
  EXPECT_TRUE(box_of(box_aperture({0, 0, 1}, {1, 1, 0})).empty());
}

}  // namespace
}  // namespace caustic::geometry
