#include "geometry/aperture.h"

#include <gtest/gtest.h>

#include "geometry/expression/expression_bound.h"
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
    case Bound::Kind::half_space:
      return y.dot(b.axis);
    case Bound::Kind::cylinder:
      return y.cross(b.axis).norm() - b.radius;
    case Bound::Kind::ball:
      return y.norm() - b.radius;
    case Bound::Kind::expression:
      break;
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
      const double bound = b.lower_bound_within(x, r);
      double least = kInfinity;
      for (int k = 0; k < 100; ++k) {
        const Point y = x + r * (k < 50 ? 1.0 : random.uniform()) * random.direction();
        least = std::min(least, b.value(y));
      }
      // Straight inwards it is attained.
      const double inwards =
          std::min(r, b.kind == Bound::Kind::half_space ? r : outside_by(b, x) + b.radius);
      least = std::min(least, b.value(x - inwards * b.gradient(x).normalized()));
      EXPECT_LE(bound, least + 1e-12);
      EXPECT_NEAR(bound, least, 1e-12);
    }
  }
}

// ---- Expressions
// ---------------------------------------------------------------------------------

Bound bound_of(const char* text, double metres = 1.0) {
  return expression_aperture(
      std::make_shared<const ExpressionBound>(read_expression(text, metres), metres));
}

constexpr const char* kApertures[] = {"x^2+y^2-1",         "4*(x^2+y^2+z^2)^2-1",
                                      "abs(x)+abs(y)-0.7", "y-x^2",
                                      "1000*(x-0.3)",      "sin(3*x)*cos(2*y)-0.1*z"};

TEST(ExpressionBound, GradientAndSlope) {
  Random random(5);
  for (const char* text : kApertures) {
    const Bound b = bound_of(text);
    for (int i = 0; i < 200; ++i) {
      const Point x = random.in_cube(1.5);
      const double h = 1e-4;
      for (int k = 0; k < 3; ++k) {
        const Vec3 e = h * Vec3::Unit(k);
        if (x.cwiseAbs().minCoeff() < h) continue;  // abs() has a kink there
        EXPECT_NEAR((b.value(x + e) - b.value(x - e)) / (2.0 * h), b.gradient(x)[k], 1e-5) << text;
      }
      // To the zero set by bisection along the gradient: there the slope is one at most.
      const Vec3 n = b.gradient(x).normalized();
      double lo = -0.5, hi = 0.5;
      if ((b.value(x + lo * n) > 0.0) == (b.value(x + hi * n) > 0.0)) continue;
      const bool rising = b.value(x + hi * n) > 0.0;
      for (int step = 0; step < 50; ++step) {
        const double middle = 0.5 * (lo + hi);
        ((b.value(x + middle * n) > 0.0) == rising ? hi : lo) = middle;
      }
      const double slope = b.gradient(x + lo * n).norm();
      EXPECT_LE(slope, 1.0 + 1e-9) << text;
      EXPECT_GT(slope, 0.05) << text;
    }
  }
}

TEST(ExpressionBound, KeepsWhereItIsNotPositive) {
  Random random(6);
  const Bound disc = bound_of("x^2+y^2-9", 0.001), half = bound_of("sqrt(x)-1");
  for (int i = 0; i < 300; ++i) {
    const Point x = random.in_cube(0.005);
    EXPECT_EQ(disc.value(x) <= 0.0, std::hypot(x.x(), x.y()) <= 0.003);
    const Point y = random.in_cube(2.0);
    EXPECT_EQ(exists_at({half}, y), y.x() >= 0.0 && y.x() <= 1.0);
  }
  EXPECT_EQ(half.value({-1, 0, 0}), kInfinity);
  EXPECT_TRUE(half.gradient({-1, 0, 0}).allFinite());
  EXPECT_FALSE(box_of({disc}).bounded());
}

TEST(ExpressionBound, LowerBoundIsOne) {
  Random random(7);
  for (const char* text : kApertures) {
    const Bound b = bound_of(text);
    for (int i = 0; i < 100; ++i) {
      const Point x = random.in_cube(1.5);
      const double r = random.log_uniform(1e-4, 0.5), bound = b.lower_bound_within(x, r);
      for (int k = 0; k < 20; ++k) {
        EXPECT_LE(bound, b.value(x + r * random.uniform() * random.direction()) + 1e-12) << text;
      }
      EXPECT_GT(b.lower_bound_within(x, 1e-9), b.value(x) - 1e-7) << text;
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
    if (random.index(2) == 0)
      bounds.push_back(cylinder_aperture(random.in_cube(1.0), {0, 1, 0}, 0.8));
    if (random.index(2) == 0)
      bounds.push_back(half_space_aperture(random.in_cube(1.0), {0, 0, -1}));
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
  EXPECT_FALSE(box_of(std::vector<Bound>{}).bounded());
  EXPECT_TRUE(box_of(box_aperture({0, 0, 1}, {1, 1, 0})).empty());
}

// Half-spaces of a box's six faces, turned and shifted, in any order: as tight as the hull of its
// corners; with one face left out as far as the others reach, and unbounded along that.
TEST(Bound, BoxOfATurnedBoxIsThatOfItsCorners) {
  Random random(8);
  for (int i = 0; i < 100; ++i) {
    const Mat3 turn = i == 0 ? Mat3(Mat3::Identity()) : random.rotation();
    const Point center = random.in_cube(5.0);
    const Vec3 half(random.log_uniform(1e-6, 1e3), random.uniform(0.1, 1.0), 1.0);
    std::vector<Bound> faces;
    Box hull{center, center};
    for (int corner = 0; corner < 8; ++corner) {
      Vec3 y;
      for (int k = 0; k < 3; ++k) y[k] = corner >> k & 1 ? half[k] : -half[k];
      const Point x = center + turn * y;
      hull = {hull.min.cwiseMin(x), hull.max.cwiseMax(x)};
    }
    for (int k = 0; k < 3; ++k) {
      for (const double s : {-1.0, 1.0}) {
        const Vec3 n = s * turn.col(k);
        faces.push_back(half_space_aperture(center + half[k] * n, n));
      }
    }
    const Box box = box_of(faces);
    EXPECT_LT((box.min - hull.min).cwiseAbs().maxCoeff(), 1e-9 * half.norm());
    EXPECT_LT((box.max - hull.max).cwiseAbs().maxCoeff(), 1e-9 * half.norm());
    faces.pop_back();
    EXPECT_FALSE(box_of(faces).bounded());
  }
}

// A cylinder across which a slab is laid: the ellipses in which they meet, and no more than a
// prism's corners beyond.
TEST(Bound, BoxOfACutCylinder) {
  Random random(9);
  for (int i = 0; i < 100; ++i) {
    const Vec3 axis = random.direction(), n = (axis + 0.3 * random.direction()).normalized();
    const double r = random.uniform(0.2, 2.0), half = random.uniform(0.2, 2.0);
    const Box box = box_of({cylinder_aperture({0, 0, 0}, axis, r), half_space_aperture(half * n, n),
                            half_space_aperture(-half * n, -n)});
    const Frame across(axis);
    Box hull{Point::Zero(), Point::Zero()};
    for (int k = 0; k < 720; ++k) {
      const Vec3 y =
          r * (std::cos(k * kPi / 360.0) * across.e1 + std::sin(k * kPi / 360.0) * across.e2);
      for (const double s : {-half, half}) {
        const Point x = y + axis * ((s - n.dot(y)) / n.dot(axis));
        hull = {hull.min.cwiseMin(x), hull.max.cwiseMax(x)};
      }
    }
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(box.min[k], hull.min[k] + 1e-9);
      EXPECT_GE(box.max[k], hull.max[k] - 1e-9);
      EXPECT_LT(box.max[k], 1.09 * hull.max[k]);
    }
  }
}

TEST(ExpressionBound, SidesWithoutAnythingAreLeftOut) {
  Random random(10);
  const Bound egg = bound_of("(x-0.3)^2+4*(y+0.2)^2+1.5*(z-0.1)^2-0.04");
  const Box about{{0.1, -0.3, 0.1 - 0.2 / std::sqrt(1.5)}, {0.5, -0.1, 0.1 + 0.2 / std::sqrt(1.5)}};
  const Box box = without_excluded_sides(Box::around({20, 70, -50}, 1e3), {egg});
  EXPECT_TRUE(box.contains(about.min) && box.contains(about.max));
  EXPECT_LT(box.diagonal(), 1.5 * about.diagonal());
  // What excludes nothing leaves all; what the others exclude is no expression's matter.
  const Box cube = Box::around({0, 0, 0}, 1.0);
  for (const Bound& b : {bound_of("x-2"), half_space_aperture({5, 0, 0}, {1, 0, 0})}) {
    EXPECT_EQ(without_excluded_sides(cube, {b}).min, cube.min);
    EXPECT_EQ(without_excluded_sides(cube, {b}).max, cube.max);
  }
  for (const char* text : kApertures) {
    const Bound b = bound_of(text);
    const Box left = without_excluded_sides(Box::around({0.2, 0, 0}, 2.0), {b});
    for (int k = 0; k < 2000; ++k) {
      const Point x = Point(0.2, 0, 0) + random.in_cube(2.0);
      EXPECT_TRUE(b.value(x) > 0.0 || left.contains(x)) << text;
    }
  }
}

}  // namespace
}  // namespace caustic::geometry
