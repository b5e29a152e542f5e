// What every surface promises, shown on one specimen of each class.
#include "geometry/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/graph_cover.h"
#include "tests/support/reference.h"
#include "tests/support/sampling.h"
#include "tests/support/thorough.h"

namespace caustic::geometry {
namespace {

using test::Random;
using test::ReferenceRay;
using test::ShapeSpec;
using Kind = ShapeSpec::Kind;

constexpr int kRays = test::thorough(100, 4);
constexpr int kPoints = test::thorough(100, 5);
constexpr int kSamplesOfRay = 400;

class EverySurface : public testing::TestWithParam<ShapeSpec> {
 protected:
  const ShapeSpec& spec() const { return GetParam(); }
  Point center() const { return spec().pose.translation; }
  // Away from apexes and rims, where nothing is smooth.
  bool regular(const Point& x, double margin = 0.05) const {
    return exists_at(surface_->own_bounds(), x, -margin) &&
           test::reference_shape(spec(), x).curvature.norm() < 20.0;
  }
  std::vector<Point> points(int n, double half = 3.0) {
    return test::sample_surface(*surface_, test::extent_about(center(), half), n, random_);
  }

  SurfacePtr surface_ = test::build(GetParam());
  Random random_{17};
};

TEST_P(EverySurface, DerivativesFollowFromTheValue) {
  for (const Point& x : points(kPoints)) {
    if (!regular(x, 0.2)) continue;
    const auto d = surface_->derivatives(x);
    Vec3 gradient;
    const double size = 1.0 + d.gradient.norm() + d.hessian.norm();
    EXPECT_NEAR(surface_->value(x), d.g, 1e-14 * size);
    EXPECT_NEAR(surface_->value_gradient(x, gradient), d.g, 1e-14 * size);
    EXPECT_NEAR((gradient - d.gradient).norm(), 0.0, 1e-14 * size);
    EXPECT_NEAR((d.hessian - d.hessian.transpose()).norm(), 0.0, 1e-14 * size);

    // Five-point differences: error h⁴ and ε/h.
    const double h = 1e-3;
    const auto derive = [&](const auto& f, const Vec3& along) -> decltype(f(x)) {
      return ((8.0 * (f(x + h * along) - f(x - h * along)) -
               (f(x + 2.0 * h * along) - f(x - 2.0 * h * along))) /
              (12.0 * h));
    };
    for (int i = 0; i < 3; ++i) {
      const Vec3 e = Vec3::Unit(i);
      EXPECT_NEAR(derive([&](const Point& y) { return surface_->value(y); }, e), d.gradient[i],
                  1e-8 * size);
      const Vec3 column = derive(
          [&](const Point& y) {
            surface_->value_gradient(y, gradient);
            return Vec3(gradient);
          },
          e);
      EXPECT_NEAR((column - d.hessian.col(i)).norm(), 0.0, 1e-8 * size);
    }
    const Vec3 u = random_.direction(), v = random_.direction();
    // ∂(∇g)/∂u∂v by second differences along u + v and u − v.
    const auto second = [&](const Vec3& along) {
      const auto at = [&](double steps) {
        surface_->value_gradient(x + steps * h * along, gradient);
        return Vec3(gradient);
      };
      return Vec3((16.0 * (at(1) + at(-1)) - at(2) - at(-2) - 30.0 * at(0)) / (12.0 * h * h));
    };
    const Vec3 third = 0.25 * (second(u + v) - second(u - v));
    const Vec3 given = surface_->third_derivative(x, u, v);
    EXPECT_NEAR((third - given).norm(), 0.0, 1e-6 * (size + given.norm()));
    const auto all = surface_->third_derivatives(x, u, v);
    const double rounding = 1e-13 * (size + given.norm());
    EXPECT_NEAR((all.uv - given).norm(), 0.0, rounding);
    EXPECT_NEAR((all.uu - surface_->third_derivative(x, u, u)).norm(), 0.0, rounding);
    EXPECT_NEAR((all.vv - surface_->third_derivative(x, v, v)).norm(), 0.0, rounding);
    EXPECT_TRUE(!surface_->at_most_quadratic() || given.norm() == 0.0);
  }
}

TEST_P(EverySurface, NormalsAndCurvaturesToRounding) {
  for (const Point& x : points(kPoints / 2)) {
    if (!regular(x)) continue;
    const auto d = surface_->derivatives(x);
    const auto r = test::reference_shape(spec(), x);
    const Vec3 n = d.gradient.normalized();
    const Mat3 P = Mat3::Identity() - n * n.transpose();
    const double bend = 1.0 + r.curvature.norm();
    EXPECT_LT((n - r.normal).norm(), 3e-14 * bend);
    EXPECT_LT((P * d.hessian * P / d.gradient.norm() - r.curvature).norm(), 1e-12 * bend * bend);
  }
}

// g/|∇g| is the distance to first order, |∇g| of order one, g < 0 inside.
TEST_P(EverySurface, ValueIsALengthWithTheContractsSign) {
  for (const Point& x : points(kPoints / 2)) {
    if (!regular(x)) continue;
    const double offset = random_.sign() * 1e-5;
    const Point y = x + offset * test::reference_shape(spec(), x).normal;
    Vec3 gradient;
    const double g = surface_->value_gradient(y, gradient);
    EXPECT_NEAR(g / gradient.norm() / offset, 1.0, 1e-3);
    if (spec().name.find("cone") == std::string::npos) {  // those grow from their apex
      EXPECT_GT(gradient.norm(), 0.05);
      EXPECT_LT(gradient.norm(), 50.0);
    }
  }
}

TEST_P(EverySurface, ChartPointsLieOnTheSurface) {
  // Ten rounded coefficients bend a cylinder by their own rounding times the distance squared;
  // terms of an expression cancel.
  const bool exact = spec().kind != Kind::quadric && spec().kind != Kind::expression;
  const double roundings = exact ? 32.0 : 256.0;
  for (const double half : {0.5, 3.0, 100.0}) {
    for (const Point& x : points(kPoints, half)) {
      const auto r = test::reference_shape(spec(), x);
      if (!regular(x, 0.01)) continue;
      EXPECT_LT(std::abs(r.distance), roundings * kEpsilon * (1.0 + x.norm())) << x.transpose();
    }
  }
}

// A box of half size `half` about x.
IntervalVec3 box_about(const Point& x, double half) { return intervals(Box::around(x, half)); }

TEST_P(EverySurface, EnclosuresHoldWhatTheyEnclose) {
  for (const Point& on : points(kPoints / 5)) {
    const double half = random_.log_uniform(1e-6, 1.0);
    const Point middle = on + random_.in_cube(2.0 * half);
    const SurfaceEnclosure e = surface_->enclose(box_about(middle, half));
    const IntervalSym333 third = surface_->enclose_third(box_about(middle, half));
    for (int i = 0; i < test::thorough(50, 10); ++i) {
      const Point x = middle + random_.in_cube(half);
      // The Hessian of an asphere knows its surface's height: on it only is it the derivative.
      if (!exists_at(surface_->own_bounds(), x, -0.01)) continue;
      const auto d = surface_->derivatives(x);
      const double slack = 1e-13 * (1.0 + x.squaredNorm()) * (1.0 + d.hessian.norm());
      const auto holds = [&](const Interval& range, double value) {
        return Interval(range.lo - slack, range.hi + slack).contains(value);
      };
      EXPECT_TRUE(holds(e.g, d.g)) << e.g.lo << " " << e.g.hi << " " << d.g;
      for (int k = 0; k < 3; ++k) EXPECT_TRUE(holds(e.gradient[k], d.gradient[k])) << k;
      for (int k = 0; k < 6; ++k) {
        const auto [row, column] = kPackedIndices[k];
        EXPECT_TRUE(holds(e.hessian[k], d.hessian(row, column))) << row << column;
      }
      for (int j = 0; j < 9; ++j) {
        const int b = j / 3, c = j % 3;
        const Vec3 T = surface_->third_derivative(x, Vec3::Unit(b), Vec3::Unit(c));
        const double more = slack * (1.0 + T.norm());
        for (int a = 0; a < 3; ++a) {
          const Interval& range = third[packed_index(a, b, c)];
          EXPECT_TRUE(Interval(range.lo - more, range.hi + more).contains(T[a])) << a << b << c;
        }
      }
    }
  }
}

// (S70): every point that exists lies in a box, alone over its place as far as the chart reaches.
TEST_P(EverySurface, GraphsCoverIt) {
  const Box region = surface_->bounds().intersected(Box::around(center(), 3.0));
  const auto own = surface_->own_bounds();
  const GraphCover cover = cover_by_graphs(*surface_, own, region);
  ASSERT_FALSE(cover.charts.empty());
  const auto holds = [](const IntervalVec3& box, const Point& x) {
    return box[0].contains(x[0]) && box[1].contains(x[1]) && box[2].contains(x[2]);
  };
  for (const Point& x : points(kPoints)) {
    if (!region.contains(x)) continue;
    int charts = 0;
    for (const GraphChart& chart : cover.charts) {
      if (!holds(chart.own, x)) continue;
      ++charts;
      Point from = x;
      from[chart.axis] = chart.reach.lo;
      RayParameters hits;
      surface_->crossings({from, Vec3::Unit(chart.axis)}, 0.0, chart.reach.width(), hits);
      EXPECT_EQ(hits.size(), 1u) << x.transpose();
    }
    for (const Box& box : cover.undecided) charts += box.contains(x);
    EXPECT_GE(charts, 1) << x.transpose();
  }
}

TEST_P(EverySurface, EnclosuresShrinkWithTheBox) {
  for (const Point& x : points(kPoints / 5)) {
    if (!regular(x)) continue;
    const auto width = [&](double half) {
      const SurfaceEnclosure e = surface_->enclose(box_about(x, half));
      Eigen::Matrix<double, 10, 1> widths;
      widths[0] = e.g.width();
      for (int k = 0; k < 3; ++k) widths[1 + k] = e.gradient[k].width();
      for (int k = 0; k < 6; ++k) widths[4 + k] = e.hessian[k].width();
      return widths.maxCoeff();
    };
    const double wide = width(1e-3), narrow = width(1e-5);
    EXPECT_LT(narrow, 0.02 * wide + 1e-11);
    // g is enclosed about as narrowly as it varies term by term.
    const auto d = surface_->derivatives(x);
    const double slope = 1.0 + d.gradient.norm() + d.hessian.norm() * (x - center()).norm();
    EXPECT_LT(surface_->enclose(box_about(x, 1e-5)).g.width(), 1e-5 * 16.0 * slope);
  }
}

// Distance from x to the nearest point of a chart: damped Gauss–Newton in the unit square from the
// best samples of a grid.
double distance_to_chart(const Chart& chart, const Point& x) {
  using Start = std::pair<double, Vec2>;
  std::vector<Start> starts;
  const int n = chart.cell.empty() ? 60 : 12;  // a chart with a cell is one of many, and small
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const Vec2 w(static_cast<double>(i) / n, static_cast<double>(j) / n);
      starts.push_back({(chart.point(w.x(), w.y()) - x).norm(), w});
    }
  }
  std::partial_sort(starts.begin(), starts.begin() + 12, starts.end(),
                    [](const Start& a, const Start& b) { return a.first < b.first; });
  // A small chart is not worth a search if it is farther away than its distances vary.
  const auto by_distance = [](const Start& a, const Start& b) { return a.first < b.first; };
  const double nearest = starts.front().first;
  const double farthest = std::max_element(starts.begin(), starts.end(), by_distance)->first;
  if (!chart.cell.empty() && nearest > farthest - nearest) return nearest;
  double best = kInfinity;
  for (int k = 0; k < 12; ++k) {
    auto [distance, w] = starts[k];
    for (int i = 0; i < 60; ++i) {
      const Vec3 off = chart.point(w.x(), w.y()) - x;
      Eigen::Matrix<double, 3, 2> J;
      for (int c = 0; c < 2; ++c) {
        Vec2 hi = w, lo = w;
        hi[c] = std::min(1.0, w[c] + 1e-6);
        lo[c] = std::max(0.0, w[c] - 1e-6);
        J.col(c) = (chart.point(hi.x(), hi.y()) - chart.point(lo.x(), lo.y())) / (hi[c] - lo[c]);
      }
      const Mat2 normal = J.transpose() * J;
      const Vec2 step =
          -(normal + 1e-14 * normal.trace() * Mat2::Identity()).inverse() * (J.transpose() * off);
      for (double shorter = 1.0; shorter > 1e-4; shorter *= 0.5) {
        const Vec2 next = (w + shorter * step).cwiseMax(0.0).cwiseMin(1.0);
        const double there = (chart.point(next.x(), next.y()) - x).norm();
        if (there >= distance) continue;
        distance = there;
        w = next;
        break;
      }
    }
    best = std::min(best, distance);
  }
  return best;
}

double distance_to_charts(const std::vector<Chart>& charts, const Point& x) {
  double best = kInfinity;
  for (const Chart& chart : charts) {
    if (exists_at(chart.cell, x, 1e-9)) best = std::min(best, distance_to_chart(chart, x));
  }
  return best;
}

TEST_P(EverySurface, ChartsCoverTheRegion) {
  const Extent extents[] = {test::extent_about(center(), 3.0),
                            {Box::around(center() + Vec3(2, 1, -1), 1.5), center(), 0.3},
                            {Box::around(center(), 30.0), center() + Vec3(0.3, 0.2, 0.1), 0.5}};
  for (const Extent& extent : extents) {
    const auto charts = surface_->charts(extent);
    const double half = 0.5 * (extent.region.max - extent.region.min).x();
    int checked = 0;
    for (int i = 0; i < 40; ++i) {
      const Point from = extent.region.center() + random_.in_cube(half);
      const Ray ray{from, extent.region.center() + random_.in_cube(half) - from};
      for (const double t : ReferenceRay(spec(), ray).roots(-2.0, 2.0, 200)) {
        const Point x = ray.at(t);
        if (!extent.region.contains(x) || !regular(x, 1e-3 * half)) continue;
        EXPECT_LT(distance_to_charts(charts, x), 1e-6 * half) << x.transpose();
        ++checked;
      }
      if (checked > test::thorough(12, 1)) break;
    }
  }
}

TEST_P(EverySurface, BoundsContainIt) {
  const Box box = surface_->bounds();
  for (const Point& x : points(3 * kPoints, 20.0)) {
    const double slack = 1e-14 * (1.0 + x.norm());
    const Box wide{box.min.array() - slack, box.max.array() + slack};
    EXPECT_TRUE(wide.contains(x)) << x.transpose();
  }
}

// ---- Rays
// ----------------------------------------------------------------------------------------

class Crossings : public EverySurface {
 protected:
  // Compares with an independent search; `length` is the largest coordinate in the game.
  void check(const Ray& ray, double t0, double t1, double length) {
    const ReferenceRay reference(spec(), ray);
    std::vector<double> expected, found;
    surface_->crossings(ray, t0, t1, found);
    EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
    const auto bounds = surface_->own_bounds();
    const double speed = ray.direction.norm();
    const double tolerance = 16.0 * kEpsilon * (1.0 + length);
    const auto outside = [&](double t) {
      return !exists_at(bounds, ray.at(t), -1e-4) || near_apex(ray.at(t));
    };
    std::erase_if(found, outside);
    for (const double t : reference.roots(t0, t1, kSamplesOfRay)) {
      if (!outside(t)) expected.push_back(t);
    }
    for (const double t : found) {
      EXPECT_GE(t, t0);
      EXPECT_LE(t, t1);
      EXPECT_LT(std::abs(reference.distance(t)), tolerance) << describe(ray, t);
    }
    for (const double t : expected) {
      // Sine of the angle between ray and surface; a displacement `tolerance` moves the root by
      // tolerance/sine, at a double root by its square root.
      const double h = 1e-4 / speed;
      const double sine =
          std::abs(reference.distance(t + h) - reference.distance(t - h)) / (2.0 * h * speed);
      const double reach = std::min(tolerance / sine, 10.0 * std::sqrt(tolerance));
      const bool at_end = std::min(t - t0, t1 - t) * speed < reach;
      const bool touches = sine < 3.0 * std::sqrt(tolerance);
      const bool listed = std::any_of(found.begin(), found.end(), [&](double f) {
        return std::abs(f - t) * speed < reach + tolerance;
      });
      EXPECT_TRUE(listed || at_end || touches) << describe(ray, t) << " sine " << sine;
    }
  }
  std::string describe(const Ray& ray, double t) const {
    std::ostringstream out;
    out.precision(17);
    out << spec().name << ": " << ray.origin.transpose() << " + " << t << " * "
        << ray.direction.transpose();
    return out.str();
  }
  bool near_apex(const Point& x) const {
    const auto r = test::reference_shape(spec(), x);
    return !(r.curvature.norm() < 1e3);
  }
};

TEST_P(Crossings, RandomRays) {
  for (int i = 0; i < kRays; ++i) {
    const Point from = center() + random_.in_cube(3.0);
    check({from, center() + random_.in_cube(2.0) - from}, -1.5, 2.5, 5.0);
  }
}

TEST_P(Crossings, UnnormalisedDirections) {
  for (int i = 0; i < test::thorough(30, 3); ++i) {
    const double length = random_.log_uniform(1e-3, 1e3);
    const Point from = center() + random_.in_cube(3.0);
    const Vec3 direction = length * (center() + random_.in_cube(2.0) - from).normalized();
    check({from, direction}, 0.0, 8.0 / length, 8.0);
  }
}

TEST_P(Crossings, FromFarAway) {
  for (const double distance : {1e2, 1e3}) {
    for (const Point& x : points(kRays / 2, 1.5)) {
      const Direction direction = random_.direction();
      check({x - distance * direction, direction}, distance - 4.0, distance + 4.0, distance);
    }
  }
}

TEST_P(Crossings, FromTheSurfaceItself) {
  for (const Point& x : points(kRays, 2.0)) {
    check({x, random_.direction()}, 0.0, 5.0, 3.0);
    check({x, random_.direction()}, 1e-6, 5.0, 3.0);
  }
}

TEST_P(Crossings, Grazing) {
  for (const Point& x : points(kRays, 2.0)) {
    if (!regular(x)) continue;
    const auto shape = test::reference_shape(spec(), x);
    const Frame frame(shape.normal.normalized());
    const double angle = random_.uniform(0.0, 2.0 * kPi);
    const Direction along = std::cos(angle) * frame.e1 + std::sin(angle) * frame.e2;
    const double offset = random_.sign() * random_.log_uniform(1e-13, 1e-2);
    const Point start = x + offset * shape.normal - 1.7 * along;
    check({start, along}, 0.0, 4.0, 4.0);
  }
}

TEST_P(Crossings, AlongAxesAndThroughTheCentre) {
  const Point middle = spec().pose.point(spec().point);
  const Direction axis = spec().pose.direction(spec().axis);
  const Frame frame(axis);
  for (const Direction& d : {axis, frame.e1, frame.e2, Direction(-axis)}) {
    check({middle - 2.0 * d, d}, 0.0, 4.0, 4.0);
    check({middle - 2.0 * d + 0.3 * frame.e1, d}, 0.0, 4.0, 4.0);
    check({middle - 2.0 * d + 1e-9 * frame.e2, d}, 0.0, 4.0, 4.0);
    check({middle - 2.0 * d + 0.3 * axis, d}, 0.0, 4.0, 4.0);
  }
}

TEST_P(Crossings, StationaryPointsAreAllFound) {
  for (int i = 0; i < test::thorough(60, 5); ++i) {
    const Point from = center() + random_.in_cube(3.0);
    const Ray ray{from, center() + random_.in_cube(2.0) - from};
    std::vector<double> found;
    surface_->stationary(ray, -1.0, 2.0, found);
    const auto slope = [&](double t) -> double {
      return surface_->derivatives(ray.at(t)).gradient.dot(ray.direction);
    };
    const auto bounds = surface_->own_bounds();
    for (const double t : found) {
      const auto d = surface_->derivatives(ray.at(t));
      EXPECT_LT(std::abs(slope(t)), 1e-11 * (1.0 + d.gradient.norm() + d.hessian.norm() * 30.0));
    }
    const int n = 3000;
    for (int k = 0; k < n; ++k) {
      const double a = -1.0 + 3.0 * k / n, b = a + 3.0 / n;
      if (!exists_at(bounds, ray.at(a), -0.01) || !exists_at(bounds, ray.at(b), -0.01)) continue;
      if ((slope(a) > 0.0) == (slope(b) > 0.0) || slope(a) == 0.0) continue;
      EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](double t) {
        return t >= a - 1e-9 && t <= b + 1e-9;
      })) << describe(ray, a);
    }
  }
}

// { side·g <= 0 } convex: a chord between two of its points stays inside.
TEST_P(EverySurface, ConvexMeansConvex) {
  for (const int side : {-1, 1}) {
    if (!surface_->convex(side)) continue;
    for (int i = 0; i < 2000; ++i) {
      const Point a = center() + random_.in_cube(3.0), b = center() + random_.in_cube(3.0);
      if (side * surface_->value(a) > 0.0 || side * surface_->value(b) > 0.0) continue;
      EXPECT_LE(side * surface_->value(a + random_.uniform() * (b - a)), 1e-12);
    }
  }
}

const auto kName = [](const auto& spec) { return spec.param.name; };
INSTANTIATE_TEST_SUITE_P(Shapes, EverySurface, testing::ValuesIn(test::shape_zoo()), kName);
INSTANTIATE_TEST_SUITE_P(Shapes, Crossings, testing::ValuesIn(test::shape_zoo()), kName);
INSTANTIATE_TEST_SUITE_P(Expressions, EverySurface, testing::ValuesIn(test::expression_zoo()),
                         kName);
INSTANTIATE_TEST_SUITE_P(Expressions, Crossings, testing::ValuesIn(test::expression_zoo()), kName);

// A ray that moves across the rim of an asphere: its crossing leaves the surface there, and goes on
// nearby as one that the surface's own bound excludes.
TEST(Asphere, CrossingsDoNotVanishAtTheRim) {
  const auto surface = make_conic(Point::Zero(), {0, 0, 1}, 1.0, 0.5, {0.02, -0.01});
  const Bound rim = surface->own_bounds().at(0);
  const double height =
      surface->charts(test::extent_about(Point::Zero(), 2.0))[0].point(1.0, 0.5).z();
  for (const Vec3& direction : {Vec3(0.1, 0, 1), Vec3(0.5, 0, 1), Vec3(0.3, 0.4, -1)}) {
    for (const double beyond : {-1e-3, -1e-6, -1e-9, 1e-9, 1e-6, 1e-3}) {
      const Point at(rim.radius + beyond, 0, height);
      std::vector<double> found;
      surface->crossings({at - direction, direction}, 0.0, 2.0, found);
      double nearest = kInfinity;
      for (const double t : found) {
        const Point x = at + (t - 1.0) * direction;
        nearest = std::min(nearest, std::abs(rim.value(x)));
        EXPECT_LT(std::abs(surface->value(x)), 1e-6);
      }
      EXPECT_LT(nearest, 2.0 * std::abs(beyond)) << direction.transpose() << " " << beyond;
    }
  }
}

TEST(Convexity, IsKnownForTheShapesThatPayForIt) {
  EXPECT_TRUE(make_sphere(Point::Zero(), 1.0)->convex(1));
  EXPECT_FALSE(make_sphere(Point::Zero(), 1.0)->convex(-1));
  EXPECT_TRUE(make_ellipsoid(Point::Zero(), {1, 2, 3}, Mat3::Identity())->convex(1));
  EXPECT_TRUE(make_cylinder(Point::Zero(), {0, 0, 1}, 1.0)->convex(1));
  EXPECT_TRUE(make_plane(Point::Zero(), {0, 0, 1})->convex(1));
  EXPECT_TRUE(make_plane(Point::Zero(), {0, 0, 1})->convex(-1));
  EXPECT_FALSE(make_torus(Point::Zero(), {0, 0, 1}, 1.0, 0.3)->convex(1));
  EXPECT_TRUE(make_conic(Point::Zero(), {0, 0, 1}, 1.0, -1.0, {})->convex(-1));
  EXPECT_TRUE(make_conic(Point::Zero(), {0, 0, 1}, -1.0, -1.0, {})->convex(1));
}

}  // namespace
}  // namespace caustic::geometry
