// Areas and fluxes of the total with the light that comes straight from the source, against solid
// angles in closed form and what is one-dimensional about an axis.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "solver/analysis.h"
#include "tests/support/scenes.h"

namespace caustic::solver {
namespace {

using geometry::box_aperture;
using geometry::kPi;
using geometry::make_sphere;
using test::absorber;
using test::floor_at;
using test::mirror;

Analysis with_direct(const OpticalSystem& system, std::vector<double> levels) {
  ContourRequest request;
  request.levels.values = std::move(levels);
  request.direct = true;
  request.time_limit = 60.0;
  Analysis analysis = analyse(system, request);
  EXPECT_FALSE(analysis.unsupported) << *analysis.unsupported;
  EXPECT_TRUE(analysis.complete);
  EXPECT_EQ(analysis.undecided, 0u);
  for (const Warning& w : analysis.warnings) ADD_FAILURE() << w.code << ": " << w.detail;
  return analysis;
}

void expect_estimate(const Estimate& found, double expected, double largest_error) {
  EXPECT_LE(std::abs(found.value - expected), found.error + 1e-12 * std::abs(expected))
      << found.value;
  EXPECT_LE(found.error, largest_error);
}

// Of a rectangle 2a by 2b, seen from above its middle.
double solid_angle(double a, double b, double h) {
  return 4.0 * std::atan(a * b / (h * std::sqrt(a * a + b * b + h * h)));
}

constexpr double kLampHeight = 2.5, kBallHeight = 0.9, kBallRadius = 0.4, kLampIntensity = 2.0;

// A ball above the middle of the floor, below the lamp.
OpticalSystem ball_below_lamp(SystemSurface ball) {
  return OpticalSystem::build(PointLight{{0, 0, kLampHeight}, kLampIntensity}, {std::move(ball)},
                              floor_at(Point::Zero(), 4, 3));
}
const double kShadowAngle =
    std::asin(kBallRadius / (kLampHeight - kBallHeight));  // half the cone's angle
double lamp_on_floor(double r) {
  return kLampIntensity * kLampHeight / std::pow(kLampHeight * kLampHeight + r * r, 1.5);
}

TEST(AnalysisOfDirectLight, IsASolidAngleWithoutThatOfABall) {
  const auto system = ball_below_lamp(absorber(make_sphere({0, 0, kBallHeight}, kBallRadius)));
  const double edge = kLampHeight * std::tan(kShadowAngle);
  const std::vector<double> levels{lamp_on_floor(1.4), lamp_on_floor(1.0), lamp_on_floor(0.3)};
  const Analysis found = with_direct(system, levels);
  const double cone = 2.0 * kPi * (1.0 - std::cos(kShadowAngle));
  const double flux = kLampIntensity * (solid_angle(2, 1.5, kLampHeight) - cone);
  expect_estimate(found.flux, flux, 1e-8);
  EXPECT_NEAR(found.average.value, flux / 12.0, 1e-11);
  EXPECT_EQ(found.min.E.value, 0.0);
  expect_estimate(found.max.E, lamp_on_floor(edge), 1e-8);
  EXPECT_NEAR(found.max.q.norm(), edge, 1e-6);
  ASSERT_EQ(found.levels.size(), 3u);
  for (const int k : {0, 1}) {
    const double r = k == 0 ? 1.4 : 1.0;
    expect_estimate(found.levels[k].area, kPi * (r * r - edge * edge), 1e-8);
    expect_estimate(found.levels[k].flux,
                    2.0 * kPi * kLampIntensity *
                        (std::cos(kShadowAngle) - std::cos(std::atan(r / kLampHeight))),
                    1e-8);
  }
  expect_estimate(found.levels[2].area, 0.0, 1e-12);
}

// The ball shines, too: what it reflects begins at the edge of its shadow. By the polar angle t of
// the ball, from the lamp's side.
TEST(AnalysisOfDirectLight, CountsWhatABallReflectsBesideItsShadow) {
  const auto system =
      ball_below_lamp(mirror(make_sphere({0, 0, kBallHeight}, kBallRadius), {}, 0.8));
  const double silhouette = std::acos(kBallRadius / (kLampHeight - kBallHeight));
  const auto psi = [](double t) {  // of the ray from the lamp
    return std::atan2(kBallRadius * std::sin(t),
                      kLampHeight - kBallHeight - kBallRadius * std::cos(t));
  };
  const auto arrival = [&](double t) {  // elevation of the ray after: ψ + 2 (π/2 − (t + ψ)) below
    const double down = 2.0 * t + psi(t) - kPi, z = kBallHeight + kBallRadius * std::cos(t);
    return kBallRadius * std::sin(t) - z * std::tan(down + kPi);
  };
  // E r dr = 0.8 I sin ψ dψ, and dE/dt by central differences of the fourth order.
  const auto slope = [](const auto& f, double t) {
    const double h = 1e-3;
    return (8.0 * (f(t + h) - f(t - h)) - (f(t + 2 * h) - f(t - 2 * h))) / (12.0 * h);
  };
  const auto reflected = [&](double t) {
    const double r = arrival(t);
    return 0.8 * kLampIntensity *
           std::abs(std::sin(psi(t)) * slope(psi, t) / (r * slope(arrival, t)));
  };
  const double edge = kLampHeight * std::tan(kShadowAngle);
  ASSERT_NEAR(arrival(silhouette), edge, 1e-12);
  const double t = silhouette - 0.15, r = arrival(t);
  ASSERT_GT(r, edge);
  ASSERT_LT(r, 1.4);
  const double level = lamp_on_floor(r) + reflected(t);
  const Analysis found = with_direct(system, {level});
  ASSERT_EQ(found.levels.size(), 1u);
  EXPECT_NEAR(found.levels[0].area.value, kPi * (r * r - edge * edge), 1e-8);
  const double direct = std::cos(kShadowAngle) - std::cos(std::atan(r / kLampHeight));
  const double mirrored = 0.8 * (std::cos(psi(t)) - std::cos(psi(silhouette)));
  EXPECT_NEAR(found.levels[0].flux.value, 2.0 * kPi * kLampIntensity * (direct + mirrored), 1e-8);
  EXPECT_LE(found.levels[0].area.error, 1e-8);
  EXPECT_LE(found.levels[0].flux.error, 1e-8);
}

// Within a mirror sphere of radius 1 a floor at height h above its middle, c above the lamp's: what
// leaves by ψ from the downward axis is reflected at the polar angle t, ψ = t + i, sin i = c sin ψ,
// and meets the sphere again at t − 2i from the upward one.
TEST(AnalysisOfDirectLight, CountsAllWaysThatASphereEnds) {
  const double h = 0.6, c = 0.05, rho = 0.8;
  const auto system = OpticalSystem::build(PointLight{{0, 0, -h - c}, kLampIntensity},
                                           {mirror(make_sphere({0, 0, -h}, 1.0), {}, rho)},
                                           floor_at(Point::Zero(), 2, 2));
  double psi = std::acos(h);
  for (int k = 0; k < 60; ++k) psi = std::acos(h) + 3.0 * std::asin(c * std::sin(psi));
  const double up = 1.0 - (h + c) / std::hypot(h + c, std::sqrt(1.0 - h * h)),
               down = 1.0 - std::cos(psi);
  const double flux = 2.0 * kPi * kLampIntensity * ((1.0 + rho) * up + rho * down);
  const Analysis found = with_direct(system, {0.5});
  expect_estimate(found.flux, flux, 1e-7);
  ASSERT_EQ(found.levels.size(), 1u);
  expect_estimate(found.levels[0].area, kPi * (1.0 - h * h), 1e-7);
  expect_estimate(found.levels[0].flux, flux, 1e-7);
}

TEST(AnalysisOfDirectLight, OfABeamIsAnArea) {
  const Vec3 beam = Vec3(0.3, -0.2, -1).normalized();
  const auto plate =
      absorber(geometry::make_plane({0, 0, 1}, {0, 0, 1}), box_aperture({0, 0, 0}, {0.3, 0.5, 2}));
  const auto system =
      OpticalSystem::build(CollimatedLight{beam, 10.0}, {plate}, floor_at(Point::Zero(), 4, 3));
  const Analysis found = with_direct(system, {5.0});
  const double E = 10.0 * -beam.z(), lit = 12.0 - 0.15;
  expect_estimate(found.flux, E * lit, 1e-9);
  expect_estimate(found.levels[0].area, lit, 1e-10);
  expect_estimate(found.levels[0].flux, E * lit, 1e-9);
  expect_estimate(found.max.E, E, 1e-9);
  EXPECT_EQ(found.min.E.value, 0.0);
}

// A beam straight down comes out of a slope of water over half of the floor: by Snell's law and as
// much light as goes in, on the side of the edge where the direct light is not.
TEST(AnalysisOfDirectLight, OfABeamOutOfWaterIsAnArea) {
  const double slope = 40.0 * kPi / 180.0, within = std::asin(1.33 * std::sin(slope));
  auto water = mirror(geometry::make_plane(Point::Zero(), {std::sin(slope), 0, std::cos(slope)}),
                      box_aperture({-9, -9, -9}, {9, 9, 9}));
  water.optics = {Optics::Kind::refract, 1.0, {}, 1.33, 1.0, false};
  const auto system = OpticalSystem::build(CollimatedLight{{0, 0, -1}, 10.0}, {water},
                                           floor_at(Point::Zero(), 4, 3));
  const double out = 10.0 * std::cos(slope) / std::cos(within) * std::cos(within - slope);
  ASSERT_GT(out, 12.0);
  ContourRequest request;
  request.levels.values = {5.0, 12.0};
  request.direct = true;
  const Analysis found = analyse(system, request);
  EXPECT_EQ(found.undecided, 0u);
  expect_estimate(found.flux, 6.0 * (10.0 + out), 1e-8);
  ASSERT_EQ(found.levels.size(), 2u);
  expect_estimate(found.levels[0].area, 12.0, 1e-9);
  expect_estimate(found.levels[1].area, 6.0, 1e-9);
  expect_estimate(found.levels[1].flux, 6.0 * out, 1e-8);
}

}  // namespace
}  // namespace caustic::solver
