// make_quadric: every class, where it stands, and what it refuses.
#include "geometry/quadric.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/reference.h"
#include "tests/support/sampling.h"
#include "tests/support/thorough.h"

namespace caustic::geometry {
namespace {

using test::Random;
using test::ShapeSpec;

struct Class {
  const char* name;
  Vec3 lambda;
  double linear, constant;
};

const Class kRegular[] = {
    {"ellipsoid", {1.0, 2.0, 4.0}, 0.0, -1.2},
    {"sphere", {1.0, 1.0, 1.0}, 0.0, -1.0},
    {"spheroid", {1.0, 1.0, 3.0}, 0.0, -1.0},
    {"one sheet", {1.0, 2.0, -1.5}, 0.0, -0.8},
    {"two sheets", {1.0, 2.0, -1.5}, 0.0, 0.8},
    {"cone", {1.0, 2.0, -1.5}, 0.0, 0.0},
    {"elliptic paraboloid", {1.0, 2.0, 0.0}, -0.7, 0.3},
    {"round paraboloid", {1.0, 1.0, 0.0}, -0.7, 0.0},
    {"hyperbolic paraboloid", {1.0, -2.0, 0.0}, -0.7, 0.3},
    {"elliptic cylinder", {1.0, 2.0, 0.0}, 0.0, -0.9},
    {"hyperbolic cylinder", {1.0, -2.0, 0.0}, 0.0, -0.9},
    {"parabolic cylinder", {1.5, 0.0, 0.0}, 0.6, 0.2},
    {"parallel planes", {1.5, 0.0, 0.0}, 0.0, -0.7},
    {"single plane", {0.0, 0.0, 0.0}, 0.8, 0.4},
};

ShapeSpec quadric(std::string name, const std::array<double, 10>& coefficients) {
  ShapeSpec spec{.name = std::move(name), .kind = ShapeSpec::Kind::quadric};
  spec.coefficients = coefficients;
  return spec;
}

// The surface and the ten coefficients as 50-digit arithmetic reads them: same side, same place.
// Errors up to `roundings` times that of a position.
void expect_same_surface(const ShapeSpec& spec, double size, Random& random,
                         double roundings = 64.0) {
  const auto result = make_quadric(spec.coefficients, spec.pose);
  ASSERT_TRUE(result.surface) << spec.name << ": " << result.fault;
  const Surface& surface = *result.surface;
  const Point middle = spec.pose.translation;
  constexpr int kPlaces = test::thorough(15, 2);
  const auto points =
      test::sample_surface(surface, test::extent_about(middle, 3.0 * size), kPlaces, random);
  EXPECT_EQ(points.size(), static_cast<std::size_t>(kPlaces)) << spec.name;
  for (const Point& x : points) {
    const auto r = test::reference_shape(spec, x);
    if (!(r.curvature.norm() * size < 50.0)) continue;
    EXPECT_LT(std::abs(r.distance), roundings * kEpsilon * (size + x.norm())) << spec.name;
    const Point off = x + random.sign() * random.log_uniform(1e-9, 1e-3) * size * r.normal;
    Vec3 gradient;
    const double g = surface.value_gradient(off, gradient);
    const double slope = gradient.norm();
    EXPECT_NEAR(g / slope, test::reference_shape(spec, off).distance,
                roundings * kEpsilon * (size + x.norm()))
        << spec.name;
    if (r.curvature.norm() * size < 10.0 && spec.name.find("cone") == std::string::npos) {
      EXPECT_GT(slope, 0.02) << spec.name;
      EXPECT_LT(slope, 50.0) << spec.name;
    }
  }
}

TEST(MakeQuadric, EveryClassAnywhereAtAnyScale) {
  Random random(1);
  for (const Class& c : kRegular) {
    for (int i = 0; i < 4; ++i) {
      const Mat3 axes = i == 0 ? Mat3::Identity() : random.rotation();
      const Point origin = i == 0 ? Point::Zero() : random.in_cube(1.0);
      ShapeSpec unit =
          quadric(c.name, test::quadric_coefficients(c.lambda, c.linear, c.constant, axes, origin));
      if (i > 2) unit.pose = Pose::make(random.direction(), 1.0, random.in_cube(1.0));
      for (const double size : {1e-6, 1.0, 1e6}) {
        for (const double multiple : {1.0, -1.0, 1e9, 1e-9}) {
          ShapeSpec spec = test::scaled(unit, size);
          for (double& k : spec.coefficients) k *= multiple;
          expect_same_surface(spec, size, random);
        }
      }
    }
  }
}

TEST(MakeQuadric, RefusesWhatIsNoSurface) {
  struct Fault {
    Vec3 lambda;
    double linear, constant;
    const char* word;
  };
  const Fault faults[] = {{{1, 2, 3}, 0, 1, "no real point"},
                          {{1, 2, 0}, 0, 1, "no real point"},
                          {{1, 0, 0}, 0, 1, "no real point"},
                          {{1, 2, 3}, 0, 0, "point"},
                          {{1, 2, 0}, 0, 0, "line"},
                          {{1, 0, 0}, 0, 0, "double plane"},
                          {{1, -2, 0}, 0, 0, "crossing planes"},
                          {{0, 0, 0}, 0, 1, "zero"},
                          {{0, 0, 0}, 0, 0, "zero"}};
  Random random(2);
  for (const Fault& f : faults) {
    for (int i = 0; i < 20; ++i) {
      const Mat3 axes = i == 0 ? Mat3::Identity() : random.rotation();
      // Rounding of shifted coefficients makes some of these a tiny ellipsoid or a slim cylinder.
      const double size = i == 0 ? 1.0 : random.log_uniform(1e-6, 1e6);
      const Vec3 lambda = random.sign() * f.lambda;
      const double sign = lambda.dot(f.lambda) < 0.0 ? -1.0 : 1.0;
      auto c = test::quadric_coefficients(lambda, f.linear, sign * f.constant, axes, Point::Zero());
      c[9] *= size * size;
      const auto result = make_quadric(c, Pose::make(random.direction(), 1.0, random.in_cube(1.0)));
      EXPECT_FALSE(result.surface) << f.word;
      EXPECT_NE(result.fault.find(f.word), std::string::npos) << result.fault;
    }
  }
}

// Shifted by whole numbers nothing rounds: still a point, a line, a double plane.
TEST(MakeQuadric, RefusesThemAwayFromTheOriginToo) {
  Random random(3);
  for (const Vec3& lambda : {Vec3(1, 2, 3), Vec3(1, 2, 0), Vec3(1, 0, 0), Vec3(1, -2, 0)}) {
    const Point origin(3, -2, 5);
    const auto c = test::quadric_coefficients(lambda, 0, 0, Mat3::Identity(), origin);
    EXPECT_FALSE(make_quadric(c, {}).surface) << lambda.transpose();
    EXPECT_FALSE(make_quadric(c, {}).fault.empty());
  }
}

// Between paraboloid and ellipsoid or hyperboloid: the centre runs away, the surface does not.
TEST(MakeQuadric, NearlyParabolic) {
  Random random(4);
  for (int i = 0; i < test::thorough(10, 2); ++i) {
    const Mat3 axes = i == 0 ? Mat3::Identity() : random.rotation();
    const Point origin = i == 0 ? Point::Zero() : random.in_cube(1.0);
    for (const double third : {1e-3, 1e-6, 1e-9, 1e-11, 3e-13, 1e-16}) {
      for (const double sign : {1.0, -1.0}) {
        for (const double second : {2.0, -2.0, 0.0}) {
          const ShapeSpec spec = quadric(
              "third " + std::to_string(std::log10(third)) + " second " + std::to_string(second),
              test::quadric_coefficients({1.0, second, sign * third}, -0.7, 0.3, axes, origin));
          expect_same_surface(spec, 1.0, random);
        }
      }
    }
  }
}

// Coefficients typed with six digits. Their centre may be some way off.
TEST(MakeQuadric, RoundedCoefficients) {
  Random random(5);
  for (const Class& c : kRegular) {
    for (int i = 0; i < test::thorough(10, 2); ++i) {
      auto k = test::quadric_coefficients(c.lambda, c.linear, c.constant, random.rotation(),
                                          random.in_cube(1.0));
      for (double& v : k) v = std::round(v * 1e6) / 1e6;
      if (!make_quadric(k, {}).surface) continue;
      expect_same_surface(quadric(c.name, k), 1.0, random, 512.0);
    }
  }
}

// Nearly a cone: the waist or the gap is small.
TEST(MakeQuadric, NearlyACone) {
  Random random(6);
  for (const double gap : {1e-2, -1e-2, 1e-6, -1e-6, 1e-10, -1e-10}) {
    const auto spec = quadric(
        "nearly a cone",
        test::quadric_coefficients({1.0, 2.0, -1.5}, 0.0, gap, random.rotation(), Point::Zero()));
    expect_same_surface(spec, 1.0, random);
  }
}

TEST(MakeQuadric, BoundsOfAPosedEllipsoid) {
  Random random(7);
  const ShapeSpec spec = [&] {
    ShapeSpec s = quadric(
        "ellipsoid",
        test::quadric_coefficients({1, 4, 9}, 0, -1, random.rotation(), random.in_cube(1.0)));
    s.pose = Pose::make(random.direction(), 2.0, random.in_cube(3.0));
    return s;
  }();
  const auto surface = test::build(spec);
  Box tight{Point::Constant(kInfinity), Point::Constant(-kInfinity)};
  for (const Point& x : test::sample_surface(
           *surface, test::extent_about(spec.pose.translation, 9.0), 20000, random)) {
    tight = {tight.min.cwiseMin(x), tight.max.cwiseMax(x)};
  }
  const Box box = surface->bounds();
  EXPECT_TRUE(((tight.min - box.min).array() > -1e-14).all());
  EXPECT_TRUE(((box.max - tight.max).array() > -1e-14).all());
  EXPECT_LT((tight.min - box.min).norm(), 0.01);
  EXPECT_LT((tight.max - box.max).norm(), 0.01);
}

}  // namespace
}  // namespace caustic::geometry
