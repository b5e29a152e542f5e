// What is particular to surfaces given by expressions: charts that cover without overlap, thin
// parts, singular points, ends of the domain, what is refused.
#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/expression/field.h"
#include "geometry/surface.h"
#include "tests/support/sampling.h"

namespace caustic::geometry {
namespace {

using test::Random;

ExpressionResult make(const char* text, double half = 1.6, const Pose& pose = {}) {
  return make_expression(read_expression(text, 1.0), Box::around(Point::Zero(), half), pose);
}

Pose some_pose() { return Pose::make(Vec3(1, 2, 3).normalized(), 0.7, {0.3, -0.2, 0.1}); }

std::vector<Chart> charts_of(const SurfacePtr& surface) {
  return surface->charts(test::extent_about(Point::Zero(), 4.0));
}

// Area of what counts: of each chart the parallelograms whose middles lie in its cell and bounds.
double area(const Surface& surface, const std::vector<Chart>& charts, int n) {
  double sum = 0.0;
  const auto bounds = surface.own_bounds();
  for (const Chart& chart : charts) {
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const double s = (i + 0.5) / n, t = (j + 0.5) / n, h = 0.01 / n;
        const Point x = chart.point(s, t);
        if (!exists_at(chart.cell, x) || !exists_at(bounds, x)) continue;
        const Vec3 x_s = chart.point(s + h, t) - chart.point(s - h, t);
        const Vec3 x_t = chart.point(s, t + h) - chart.point(s, t - h);
        sum += x_s.cross(x_t).norm() / (4.0 * h * h * n * n);
      }
    }
  }
  return sum;
}

TEST(ExpressionCharts, CoverOnce) {
  struct Case {
    const char* text;
    double area;
    std::size_t most;
  };
  const double pi = kPi, side = 3.2;
  const Case cases[] = {
      {"x^2+y^2+z^2-1", 4.0 * pi, 6},
      {"(x^2+y^2+z^2+0.75)^2-4*(x^2+y^2)", 4.0 * pi * pi * 0.5, 60},
      {"(sqrt(x^2+y^2)-1)^2+z^2-0.16", 4.0 * pi * pi * 0.4, 75},
      {"z*(z-1)*(z+1)", 3.0 * side * side, 3},  // sheets where boxes are likely to be cut
      {"x^2+y^2-1", 2.0 * pi * side, 4},
      {"abs(x)+abs(y)+abs(z)-1", 4.0 * std::sqrt(3.0), 8},
      {"x+y+z", 0.75 * std::sqrt(3.0) * side * side, 1},
  };
  for (const Case& c : cases) {
    const auto surface = make(c.text, 0.5 * side, some_pose()).surface;
    ASSERT_TRUE(surface) << c.text;
    const auto charts = charts_of(surface);
    EXPECT_LE(charts.size(), c.most) << c.text;
    // Narrow strips of cells need many samples.
    const int n = static_cast<int>(300.0 / std::sqrt(static_cast<double>(charts.size())));
    EXPECT_NEAR(area(*surface, charts, n) / c.area, 1.0, 0.01) << c.text << " " << charts.size();
  }
}

TEST(ExpressionCharts, GoOnBeyondTheirCells) {
  Random random(1);
  const auto surface = make("x^4+y^4+z^4-x^2-y^2-z^2").surface;
  const auto charts = charts_of(surface);
  EXPECT_LT(charts.size(), 60u);
  const auto given = make("x^4+y^4+z^4-x^2-y^2-z^2", 1.3).surface;  // as in the example
  EXPECT_EQ(charts_of(given).size(), 6u);
  for (const Chart& chart : charts) {
    for (int i = 0; i < 200; ++i) {
      // Neighbours in the square are neighbours in space: no jump where the surface leaves the
      // cell.
      const double s = random.uniform(), t = random.uniform(), h = 1e-6;
      const Point x = chart.point(s, t), near = chart.point(std::min(1.0, s + h), t);
      EXPECT_TRUE(x.allFinite());
      EXPECT_LT((near - x).norm(), 1e-3);
    }
  }
}

TEST(ExpressionCharts, OnlyWhatTheRegionNeeds) {
  const auto surface = make("x^2+y^2+z^2-1").surface;
  const auto all = charts_of(surface);
  const auto few = surface->charts({Box{{0.9, -0.1, -0.1}, {1.1, 0.1, 0.1}}, Point::Zero(), 1.0});
  EXPECT_LT(few.size(), all.size());
  EXPECT_GE(few.size(), 1u);
}

// Two routes to one torus.
TEST(ExpressionSurface, EqualsTheTorusWrittenByHand) {
  Random random(2);
  const Pose pose = some_pose();
  const auto by_hand =
      make_torus(pose.point(Point::Zero()), pose.direction(Vec3::UnitZ()), 1.0, 0.5);
  const auto compiled = make("(x^2+y^2+z^2+0.75)^2-4*(x^2+y^2)", 1.6, pose).surface;
  for (int i = 0; i < 300; ++i) {
    const Point x = pose.point(random.in_cube(1.5));
    const auto a = by_hand->derivatives(x), b = compiled->derivatives(x);
    const double ratio = b.gradient.norm() / a.gradient.norm();
    EXPECT_NEAR(b.g, ratio * a.g, 1e-12);
    EXPECT_NEAR((b.gradient - ratio * a.gradient).norm(), 0.0, 1e-12);
    EXPECT_NEAR((b.hessian - ratio * a.hessian).norm(), 0.0, 1e-11);
    const Ray ray{pose.point(3.0 * random.direction()), random.in_cube(1.0)};
    const Ray towards{ray.origin, pose.point(ray.direction) - ray.origin};
    for (const bool crossings : {true, false}) {
      RayParameters p, q;
      if (crossings)
        by_hand->crossings(towards, 0.0, 2.0, p);
      else
        by_hand->stationary(towards, 0.3, 1.3, p);
      if (crossings)
        compiled->crossings(towards, 0.0, 2.0, q);
      else
        compiled->stationary(towards, 0.3, 1.3, q);
      if (!crossings) {  // rays are followed a little beyond the bounds only
        const auto bounds = compiled->own_bounds();
        const auto outside = [&](double t) { return !exists_at(bounds, towards.at(t)); };
        std::erase_if(p, outside);
        std::erase_if(q, outside);
      }
      ASSERT_EQ(p.size(), q.size());
      for (std::size_t k = 0; k < p.size(); ++k) EXPECT_NEAR(p[k], q[k], 1e-6);
    }
  }
}

// Plates 2e-4 thick and less: every ray through them has two crossings.
TEST(ExpressionSurface, ThinPartsAreNotMissed) {
  Random random(3);
  for (const char* text :
       {"z^2-1e-8", "abs(z)-1e-4", "x^2+y^2+1e8*z^2-3", "z^6-1e-24", "1e8*z^2+exp(x^2+y^2)-30"}) {
    const auto surface = make(text, 1.2).surface;
    ASSERT_TRUE(surface) << text;
    for (int i = 0; i < 100; ++i) {
      Point from = random.in_cube(1.0), to = random.in_cube(1.0);
      from.z() = 1.0;
      to.z() = random.sign() < 0.0 ? -1.0 : -0.01;
      RayParameters found;
      surface->crossings({from, to - from}, 0.0, 1.0, found);
      ASSERT_EQ(found.size(), 2u) << text << " " << from.transpose() << " " << to.transpose();
    }
  }
}

// ∇g = 0 and g = 0 at the cuboid's centre.
TEST(ExpressionSurface, SingularPointsAreNoTrouble) {
  const auto surface = make("x^4+y^4+z^4-x^2-y^2-z^2").surface;
  ASSERT_TRUE(surface);
  for (const Chart& chart : charts_of(surface)) {
    for (const double s : {0.0, 0.5, 1.0}) {
      const Point x = chart.point(s, s);
      EXPECT_TRUE(x.allFinite());
      if (exists_at(chart.cell, x)) {
        EXPECT_GT(x.norm(), 0.5);
      }
    }
  }
  RayParameters found;
  surface->crossings({{-2, 0, 0}, {1, 0, 0}}, 0.0, 4.0, found);
  EXPECT_NEAR(found.front(), 1.0, 1e-14);
  EXPECT_NEAR(found.back(), 3.0, 1e-14);
  // A node is not charted, its cones are.
  const auto cone = make("x^2+y^2-z^2", 1.0).surface;
  ASSERT_TRUE(cone);
  EXPECT_LT(charts_of(cone).size(), 200u);
}

TEST(ExpressionSurface, EndsOfTheDomain) {
  const auto cap = make("z-sqrt(1-x^2-y^2)").surface;
  ASSERT_TRUE(cap);
  EXPECT_TRUE(std::isnan(cap->value({2, 0, 0})));
  RayParameters found;
  cap->crossings({{0.2, 0.1, 3}, {0, 0, -1}}, 0.0, 10.0, found);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0], 3.0 - std::sqrt(0.95), 1e-14);
  found.clear();
  cap->crossings({{1.2, 0.1, 3}, {0, 0, -1}}, 0.0, 10.0, found);
  EXPECT_TRUE(found.empty());
  found.clear();
  cap->crossings({{-3, 0, 0.5}, {1, 0, 0}}, 0.0, 10.0, found);
  ASSERT_EQ(found.size(), 2u);
  const SurfaceEnclosure e =
      cap->enclose({Interval(0.9, 1.1), Interval(0.0, 0.1), Interval(0.0, 0.1)});
  EXPECT_TRUE(e.gradient[2].contains(Interval::whole()));
}

TEST(ExpressionSurface, SaysWhatItCannotBe) {
  const auto fault = [](const char* text) { return make(text); };
  EXPECT_EQ(fault("x^2+y^2+z^2+1").fault, "the surface has no points in these bounds");
  EXPECT_FALSE(fault("x^2+y^2+z^2+1").of_expression);
  EXPECT_FALSE(fault("x-5").surface);
  EXPECT_EQ(fault("sqrt(-1-x^2)").fault, "is undefined everywhere in its bounds");
  EXPECT_TRUE(fault("sqrt(-1-x^2)").of_expression);
  EXPECT_FALSE(fault("(x^2+y^2+z^2-1)^2").surface);
  EXPECT_TRUE(fault("(x^2+y^2+z^2-1)^2").of_expression);
  EXPECT_FALSE(fault("1/x").surface);
}

TEST(ExpressionSurface, ConvexityOfQuadrics) {
  EXPECT_TRUE(make("x^2+y^2+z^2-1").surface->convex(1));
  EXPECT_FALSE(make("x^2+y^2+z^2-1").surface->convex(-1));
  EXPECT_TRUE(make("1-x^2-y^2").surface->convex(-1));
  EXPECT_FALSE(make("x^2-y^2+z").surface->convex(1));
  EXPECT_FALSE(make("x^4+y^4+z^4-1").surface->convex(1));
}

}  // namespace
}  // namespace caustic::geometry
