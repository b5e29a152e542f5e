// Areas and fluxes of the total against closed forms, one-dimensional integrals written out here,
// and random points.
#include "solver/analysis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "solver/point_irradiance.h"
#include "tests/support/analysis_checks.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"
#include "tests/support/strips.h"
#include "tests/support/thorough.h"
#include "tests/support/total_scenes.h"

namespace caustic::solver {
namespace {

using geometry::kPi;
using test::analysis_of;
using test::expect_holds;
using test::floor_at;
using test::one_mirror;
using test::Random;
using test::root_of;
using test::simpson;
using test::Strips;
using test::thorough;

// A level or two do under a sanitizer.
constexpr bool kFew = test::kSanitized;

TEST(Analysis, OfABallUnderItsLamp) {
  const auto system =
      one_mirror(PointLight{{0, 0, 4}, 2.0}, geometry::make_sphere(Point::Zero(), 1.0),
                 floor_at({0, 0, 6}, 12, 12), {}, 0.8);
  // At the polar angle θ of the ball: ψ of the light before, β after, both to the axis.
  const auto psi = [](double t) { return std::atan2(std::sin(t), 4.0 - std::cos(t)); };
  const auto psi_t = [](double t) {
    const double s = std::sin(t), c = 4.0 - std::cos(t);
    return (std::cos(t) * c - s * s) / (s * s + c * c);
  };
  const auto radius = [&](double t) {
    return std::sin(t) + (6.0 - std::cos(t)) * std::tan(2.0 * t + psi(t));
  };
  const auto E = [&](double t) {
    const double tan = std::tan(2.0 * t + psi(t));
    const double radius_t = std::cos(t) + std::sin(t) * tan +
                            (6.0 - std::cos(t)) * (1.0 + tan * tan) * (2.0 + psi_t(t));
    return 1.6 * std::sin(psi(t)) * psi_t(t) / (radius(t) * radius_t);
  };
  const std::vector<double> levels{8e-4, 5e-4};
  for (const double chord : {1e-4, 1e-3, 5e-3}) {
    const auto analysis = analysis_of(system, levels, chord);
    ASSERT_EQ(analysis.levels.size(), 2u);
    for (const LevelAnalysis& level : analysis.levels) {
      const double t = root_of([&](double at) { return E(at) - level.level; }, 0.01, 0.5);
      expect_holds(level.area, kPi * radius(t) * radius(t), 1e-6);
      expect_holds(level.flux, 3.2 * kPi * (1.0 - std::cos(psi(t))), 1e-9);
    }
    // Brightest under the lamp, where radius/ψ = 38, faintest in the corners.
    const double corner = root_of([&](double t) { return radius(t) - std::sqrt(72.0); }, 0.01, 0.5);
    expect_holds(analysis.max.E, 1.6 / (38.0 * 38.0), 1e-12);
    EXPECT_LT(analysis.max.q.norm(), 1e-6);
    expect_holds(analysis.min.E, E(corner), 1e-12);
    EXPECT_NEAR(analysis.min.q.cwiseAbs().minCoeff(), 6.0, 1e-9);
    EXPECT_NEAR(*analysis.min_to_max(), E(corner) * 38.0 * 38.0 / 1.6, 1e-9);
    EXPECT_NEAR(*analysis.min_to_average(), E(corner) * 144.0 / analysis.flux.value, 1e-9);
  }
}

TEST(Analysis, OfABallOfMetal) {
  auto ball = test::mirror(geometry::make_sphere(Point::Zero(), 1.0));
  ball.optics.metal = {0.2, 3.0};
  const auto system =
      OpticalSystem::build(PointLight{{0, 0, 4}, 1.0}, {ball}, floor_at({0, 0, 6}, 30, 30));
  // Above the faintest level all of the disc is brighter; levels by the sheet's own irradiance.
  const auto psi = [](double t) { return std::atan2(std::sin(t), 4.0 - std::cos(t)); };
  const auto share = [&](double t) { return test::fresnel({0.2, 3.0}, t + psi(t)); };
  const auto radius = [&](double t) {
    return std::sin(t) + (6.0 - std::cos(t)) * std::tan(2.0 * t + psi(t));
  };
  const auto analysis = analysis_of(system, {8e-5, 2e-4, 4e-4});
  for (const LevelAnalysis& level : analysis.levels) {
    const double r = std::sqrt(level.area.value / kPi);
    const double t = root_of([&](double at) { return radius(at) - r; }, 0.0, 0.6);
    // dΩ = 2π sin ψ dψ
    const double flux = simpson(
        [&](double at) {
          const double s = std::sin(at), c = 4.0 - std::cos(at), dd = s * s + c * c;
          return 2.0 * kPi * share(at) * s / std::sqrt(dd) * (std::cos(at) * c - s * s) / dd;
        },
        0.0, t, 400);
    expect_holds({level.flux.value, level.flux.error + 1e-11}, flux, 1e-9);
    LightMeter meter(system, {}, false);
    EXPECT_NEAR(meter.at({r, 0}).E, level.level, 1e-9 * level.level);
  }
}

TEST(Analysis, OfWaterWavesIsOneDimensional) {
  const std::vector<double> levels = kFew ? std::vector{3.0} : std::vector{0.8, 1.5, 3.0, 10.0};
  const Strips strips = test::strips_of_water(1.0);
  const double all = strips.above(1e-3, 0.0, 1.0).second;
  std::vector<std::pair<double, double>> expected;
  for (const double level : levels) expected.push_back(strips.above(level, 0.0, 1.0));
  for (const double chord : {1e-2, 1e-4}) {
    const auto analysis = analysis_of(test::water_waves(1.0), levels, chord);
    expect_holds(analysis.flux, all, 1e-8);
    for (std::size_t i = 0; i < levels.size(); ++i) {
      expect_holds(analysis.levels[i].area, expected[i].first, 1e-8);
      expect_holds(analysis.levels[i].flux, expected[i].second, 1e-8);
    }
    if (kFew) break;
  }
}

// A trough x² + z² = 1, |x| ≤ 0.6, of metal, lit from above: at the angle p from its bottom the
// light turns by 2p, and loses what Fresnel's equations say.
TEST(Analysis, OfATroughOfMetalIsOneDimensional) {
  constexpr double kHeight = -0.55;
  const std::complex<double> metal(0.2, 3.0);
  const auto up = [](double p) { return kHeight + std::cos(p); };
  const double end = std::asin(0.6);
  const Strips strips([=](double p) { return std::sin(p) - up(p) * std::tan(2 * p); },
                      [=](double p) {
                        const double tan = std::tan(2 * p);
                        return std::cos(p) + std::sin(p) * tan - 2.0 * up(p) * (1.0 + tan * tan);
                      },
                      [=](double p) { return std::cos(p) * test::fresnel(metal, p); }, -end, end);
  auto trough = test::mirror(geometry::make_cylinder(Point::Zero(), {0, 1, 0}, 1.0),
                             geometry::box_aperture({-0.6, -1, -1.1}, {0.6, 1, -0.5}));
  trough.optics.metal = metal;
  const auto system = OpticalSystem::build(CollimatedLight{{0, 0, -1}, 1.0}, {trough},
                                           floor_at({0, 0, kHeight}, 0.5, 0.5));
  const auto analysis =
      analysis_of(system, kFew ? std::vector{10.0} : std::vector{3.0, 10.0}, kFew ? 1e-2 : 1e-3);
  expect_holds(analysis.flux, 0.5 * strips.above(1e-3, -0.25, 0.25).second, 1e-8);
  for (const LevelAnalysis& level : analysis.levels) {
    const auto [width, flux] = strips.above(level.level, -0.25, 0.25);
    EXPECT_GT(width, 0.0);
    expect_holds(level.area, 0.5 * width, 1e-8);
    expect_holds(level.flux, 0.5 * flux, 1e-8);
  }
}

// 10⁷ by ISOCAUSTIC_SAMPLES=10000000.
int analysis_samples() {
  const char* wanted = std::getenv("ISOCAUSTIC_SAMPLES");
  return wanted ? std::atoi(wanted) : thorough(6000, 500);
}

/// A random place where light leaves the mirror: its arrival, and the flux per sample that it
/// stands for.
using Emission = std::function<std::pair<Vec2, double>(Random&)>;

/// Areas by random points of the receiver, fluxes by random points of the mirror, each with the
/// meter's reading: within four standard deviations.
void expect_what_random_points_say(const OpticalSystem& system, const Analysis& analysis,
                                   const Emission& emit) {
  LightMeter meter(system, {}, false);
  Random random(4711);
  const Vec2 half = system.receiver().half;
  const int samples = analysis_samples();
  const std::size_t n = analysis.levels.size();
  std::vector<double> inside(n), flux(n), flux2(n);
  double all = 0.0, all2 = 0.0;
  const auto total = [&](const Vec2& q) {
    const auto reading = meter.at(q);
    return reading.on_caustic ? geometry::kInfinity : reading.E;
  };
  for (int k = 0; k < samples; ++k) {
    const double at_random =
        total({random.uniform(-half.x(), half.x()), random.uniform(-half.y(), half.y())});
    const auto [q, weight] = emit(random);
    const bool arrives = system.receiver().contains(q);
    const double at_arrival = arrives ? total(q) : 0.0;
    all += arrives * weight;
    all2 += arrives * weight * weight;
    for (std::size_t i = 0; i < n; ++i) {
      const double level = analysis.levels[i].level;
      inside[i] += at_random >= level;
      if (!(at_arrival >= level)) continue;
      flux[i] += weight;
      flux2[i] += weight * weight;
    }
  }
  const auto expect_mean = [&](const Estimate& found, double sum, double sum2) {
    const double mean = sum / samples;
    const double noise = std::sqrt((sum2 / samples - mean * mean) / samples);
    EXPECT_NEAR(found.value, mean, 4.0 * noise + found.error);
  };
  const double area = 4.0 * half.x() * half.y();
  expect_mean(analysis.flux, all, all2);
  for (std::size_t i = 0; i < n; ++i) {
    SCOPED_TRACE(analysis.levels[i].level);
    expect_mean(analysis.levels[i].area, area * inside[i], area * area * inside[i]);
    expect_mean(analysis.levels[i].flux, flux[i], flux2[i]);
  }
}

TEST(Analysis, OfTheNephroidRing) {
  const auto system = test::nephroid_ring();
  // From (cos φ, sin φ, z) light arrives at (cos φ − z cos 2φ, sin φ − z sin 2φ).
  const auto arrival = [](double phi, double z) {
    return Vec2(std::cos(phi) - z * std::cos(2 * phi) - 0.5, std::sin(phi) - z * std::sin(2 * phi));
  };
  const auto analysis = analysis_of(system, {1e-6, 1.0, 2.0, 4.0});
  expect_what_random_points_say(system, analysis, [&](Random& random) {
    const double phi = random.uniform(-kPi / 3, kPi / 3), z = random.uniform(0.0, 1.0);
    return std::pair(arrival(phi, z), 2 * kPi / 3 * std::cos(phi) / std::sqrt(2.0));
  });
  // All flux: the part of each line φ = const that falls on the receiver.
  constexpr int kLines = 400'000;
  double flux = 0.0;
  for (int i = 0; i < kLines; ++i) {
    const double phi = kPi / 3 * ((i + 0.5) / kLines * 2.0 - 1.0);
    double lo = 0.0, hi = 1.0;
    for (const int axis : {0, 1}) {
      const double at = arrival(phi, 0.0)[axis], along = arrival(phi, 1.0)[axis] - at;
      const double w0 = (-0.6 - at) / along, w1 = (0.6 - at) / along;
      lo = std::max(lo, std::min(w0, w1));
      hi = std::min(hi, std::max(w0, w1));
    }
    flux += std::max(0.0, hi - lo) * std::cos(phi) / std::sqrt(2.0) * 2.0 * kPi / 3.0 / kLines;
  }
  EXPECT_NEAR(analysis.flux.value, flux, 1e-9);
  // The bands between levels make up all of it: nowhere is light fainter than 1e-6.
  EXPECT_NEAR(analysis.levels[0].flux.value, analysis.flux.value, 1e-9);
  EXPECT_LE(analysis.flux.error, 1e-8);
  EXPECT_TRUE(analysis.max.unbounded);
  EXPECT_TRUE(LightMeter(system, {}, false).at(analysis.max.q).on_caustic);
  EXPECT_EQ(analysis.min.E.value, 0.0);
  EXPECT_EQ(LightMeter(system, {}, false).at(analysis.min.q).E, 0.0);
  EXPECT_EQ(analysis.min_to_max(), 0.0);
  for (const LevelAnalysis& level : analysis.levels) {
    EXPECT_LE(level.area.error, 1e-8);
    EXPECT_LE(level.flux.error, 1e-8);
  }
}

// Two tilted plates whose patches of light overlap.
TEST(Analysis, OfOverlappingPatches) {
  const auto system = test::two_plates();
  const auto analysis = analysis_of(system, {0.05, 0.09, 0.12});
  expect_what_random_points_say(system, analysis, [&](Random& random) {
    const auto& [middle, n, lo, hi, reflectance] = test::kPlates[random.uniform(0.0, 1.0) < 0.5];
    Point x(random.uniform(lo.x(), hi.x()), random.uniform(lo.y(), hi.y()), 0.0);
    x.z() = -(n.x() * (x.x() - middle.x()) + n.y() * (x.y() - middle.y())) / n.z();
    const Vec3 d = x - test::kLampOverPlates, out = d - 2.0 * d.dot(n) * n;
    const double tau = (1.5 - x.z()) / out.z();
    const double area = 2.0 * (hi - lo).prod() / n.z();
    const double weight = reflectance * area * std::abs(d.dot(n)) / std::pow(d.norm(), 3);
    return std::pair(Vec2(x.x() + tau * out.x(), x.y() + tau * out.y()), weight);
  });
}

TEST(Analysis, WhereNothingArrives) {
  const auto system =
      one_mirror(PointLight{{0, 0, 4}, 1.0}, geometry::make_sphere(Point::Zero(), 1.0),
                 floor_at({0, 0, -40}, 1, 1));
  ContourRequest request;
  request.levels.values = {1.0, 2.0};
  const auto analysis = analyse(system, request);
  EXPECT_EQ(analysis.flux.value, 0.0);
  ASSERT_EQ(analysis.levels.size(), 2u);
  EXPECT_EQ(analysis.levels[1].area.value, 0.0);
  EXPECT_EQ(analysis.max.E.value, 0.0);
  EXPECT_FALSE(analysis.min_to_average());
}

// A ball above a mirror hides two cones of light, before and after it, that do not overlap.
TEST(Analysis, BehindABallMissesTwoCones) {
  const Point lamp(0.1, 0.05, 1.5), center(0.4, 0.1, 0.7);
  const double radius = 0.1;
  const auto system =
      OpticalSystem::build(PointLight{lamp, 2.0},
                           {test::mirror(geometry::make_plane({0, 0, 0}, {0, 0, 1}),
                                         geometry::box_aperture({-1, -1, -1}, {1, 1, 1})),
                            test::absorber(geometry::make_sphere(center, radius))},
                           floor_at({0, 0, 2}, 6, 6));
  const auto corner = [&](double x, double y) {
    const double u = x - lamp.x(), v = y - lamp.y(), h = lamp.z();
    return std::atan(u * v / (h * std::sqrt(u * u + v * v + h * h)));
  };
  const double mirror = corner(1, 1) - corner(-1, 1) - corner(1, -1) + corner(-1, -1);
  const auto cone = [&](const Point& from) {
    const double sine = radius / (center - from).norm();
    return 2.0 * kPi * (1.0 - std::sqrt(1.0 - sine * sine));
  };
  const double seen = mirror - cone(lamp) - cone({lamp.x(), lamp.y(), -lamp.z()});
  expect_holds(analysis_of(system, {0.05}, 6e-4).flux, 2.0 * seen, 1e-4);
}

TEST(Analysis, SaysWhatItLacks) {
  ContourRequest request;
  request.levels.values = {1.0};
  // From one focus all light meets the other.
  const auto focused = one_mirror(
      PointLight{{0, 0, -0.6}, 1.0},
      geometry::make_ellipsoid(Point::Zero(), {0.8, 0.8, 1.0}, geometry::Mat3::Identity()),
      floor_at({0, 0, 0.6}, 0.4, 0.4), geometry::box_aperture({-1, -1, -1}, {1, 1, 0.3}));
  EXPECT_TRUE(analyse(focused, request).unsupported);
}

}  // namespace
}  // namespace caustic::solver
