// Areas and fluxes of the total against closed forms, one-dimensional integrals written out here,
// and random points.
#include "solver/analysis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <functional>

#include "geometry/expression/field.h"
#include "solver/point_irradiance.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace caustic::solver {
namespace {

using geometry::kPi;
using test::floor_at;
using test::one_mirror;
using test::Random;

Analysis analysis_of(const OpticalSystem& system, std::vector<double> levels, double chord = 0.0) {
  ContourRequest request;
  request.levels.values = std::move(levels);
  request.chord_tolerance = chord;
  request.time_limit = 60.0;
  Analysis analysis = analyse(system, request);
  EXPECT_FALSE(analysis.unsupported) << *analysis.unsupported;
  EXPECT_TRUE(analysis.complete);
  EXPECT_EQ(analysis.undecided, 0u);
  for (const Warning& w : analysis.warnings) ADD_FAILURE() << w.code << ": " << w.detail;
  return analysis;
}

/// The estimate holds, and is worth something. The expected value is good to 1e-12.
void expect_holds(const Estimate& found, double expected, double largest_error) {
  const double rounding = 1e-12 * std::abs(expected);
  EXPECT_LE(std::abs(found.value - expected), found.error + rounding) << found.value;
  EXPECT_LE(found.error, largest_error);
}

double root_of(const auto& f, double a, double b) {
  const bool positive = f(b) > 0.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (a + b);
    ((f(middle) > 0.0) == positive ? b : a) = middle;
  }
  return 0.5 * (a + b);
}

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

/// Unpolarised reflectance at the angle of incidence, by the amplitudes across and along.
double reflectance(std::complex<double> index, double angle) {
  const std::complex<double> sine = std::sin(angle) / index, cosine = std::sqrt(1.0 - sine * sine);
  const double c = std::cos(angle);
  return 0.5 * (std::norm((c - index * cosine) / (c + index * cosine)) +
                std::norm((index * c - cosine) / (index * c + cosine)));
}

double simpson(const auto& f, double a, double b, int panels) {
  double sum = f(a) + f(b);
  for (int i = 1; i < 2 * panels; ++i)
    sum += (i % 2 ? 4.0 : 2.0) * f(a + (b - a) * i / (2.0 * panels));
  return sum * (b - a) / (6.0 * panels);
}

TEST(Analysis, OfABallOfMetal) {
  auto ball = test::mirror(geometry::make_sphere(Point::Zero(), 1.0));
  ball.optics.metal = {0.2, 3.0};
  const auto system =
      OpticalSystem::build(PointLight{{0, 0, 4}, 1.0}, {ball}, floor_at({0, 0, 6}, 30, 30));
  // Above the faintest level all of the disc is brighter; levels by the sheet's own irradiance.
  const auto psi = [](double t) { return std::atan2(std::sin(t), 4.0 - std::cos(t)); };
  const auto share = [&](double t) { return reflectance({0.2, 3.0}, t + psi(t)); };
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

// Light that only spreads in one direction: all is a function of a parameter p of the surface, and
// of u on the receiver.
class Strips {
 public:
  using Function = std::function<double(double)>;
  /// Where p sends its light, the derivative, and how much light there is per p.
  Strips(Function arrival, Function slope, Function density, double begin, double end)
      : arrival_(std::move(arrival)), slope_(std::move(slope)), density_(std::move(density)) {
    folds_.push_back(begin);
    for (int i = 0; i < 3000; ++i) {
      const double a = begin + (end - begin) * i / 3000, b = begin + (end - begin) * (i + 1) / 3000;
      if ((slope_(a) > 0.0) != (slope_(b) > 0.0)) folds_.push_back(root_of(slope_, a, b));
    }
    folds_.push_back(end);
  }
  double irradiance(double u) const {
    double sum = 0.0;
    for (const double p : places(u)) sum += density_(p) / std::abs(slope_(p));
    return sum;
  }
  /// Width of what is at least so bright between lo and hi, and the light onto that per length.
  std::pair<double, double> above(double level, double lo, double hi) const {
    std::pair<double, double> sum{0.0, 0.0};
    for (const auto& [begin, end] : strips(level, lo, hi)) {
      sum.first += end - begin;
      sum.second += flux(begin, end);
    }
    return sum;
  }

 private:
  /// Between folds the map is monotone: its inverses at u.
  std::vector<double> places(double u) const {
    std::vector<double> found;
    for (std::size_t i = 0; i + 1 < folds_.size(); ++i) {
      const double a = folds_[i], b = folds_[i + 1];
      if ((arrival_(a) > u) != (arrival_(b) > u))
        found.push_back(root_of([&](double p) { return arrival_(p) - u; }, a, b));
    }
    return found;
  }
  /// Intervals of [lo, hi] where the irradiance is at least `level`, cut at caustics and ends.
  std::vector<std::pair<double, double>> strips(double level, double lo, double hi) const {
    std::vector<double> cuts{lo, hi};
    for (const double p : folds_) {
      if (arrival_(p) > lo && arrival_(p) < hi) cuts.push_back(arrival_(p));
    }
    std::sort(cuts.begin(), cuts.end());
    std::vector<std::pair<double, double>> found;
    for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
      constexpr int kSamples = 40;
      // Denser towards the caustics, which the ends may be.
      const auto at = [&](int i) {
        const double s = std::sin(0.5 * kPi * (i + 0.5) / kSamples);
        return cuts[k] + (cuts[k + 1] - cuts[k]) * s * s;
      };
      const auto excess = [&](double u) { return irradiance(u) - level; };
      double begin = excess(at(0)) >= 0.0 ? cuts[k] : NAN;
      for (int i = 0; i + 1 < kSamples; ++i) {
        if ((excess(at(i)) >= 0.0) == (excess(at(i + 1)) >= 0.0)) continue;
        const double edge = root_of(excess, at(i), at(i + 1));
        if (std::isnan(begin)) {
          begin = edge;
        } else {
          found.emplace_back(begin, edge);
          begin = NAN;
        }
      }
      if (!std::isnan(begin)) found.emplace_back(begin, cuts[k + 1]);
    }
    return found;
  }
  /// Between two values of u within which no caustic lies.
  double flux(double u0, double u1) const {
    double sum = 0.0;
    for (std::size_t i = 0; i + 1 < folds_.size(); ++i) {
      const double a = folds_[i], b = folds_[i + 1];
      const bool rises = arrival_(b) > arrival_(a);
      const auto inverse = [&](double u) {
        if ((rises ? arrival_(a) : arrival_(b)) >= u) return rises ? a : b;
        if ((rises ? arrival_(b) : arrival_(a)) <= u) return rises ? b : a;
        return root_of([&](double p) { return arrival_(p) - u; }, a, b);
      };
      sum += std::abs(simpson(density_, inverse(u0), inverse(u1), 100));
    }
    return sum;
  }

  Function arrival_, slope_, density_;
  std::vector<double> folds_;  // and the ends
};

// Water z = 0.1 sin 2πx over a floor, lit from above.
Strips strips_of_water(double depth) {
  // Tangent of the refracted ray's angle to the vertical, and its derivative.
  const auto refracted = [](double x) {
    const double f = 0.2 * kPi * std::cos(2 * kPi * x),
                 f_x = -0.4 * kPi * kPi * std::sin(2 * kPi * x);
    const double in = std::atan(f), out = std::asin(std::sin(in) / 1.33);
    const double in_x = f_x / (1.0 + f * f);
    const double out_x = std::cos(in) * in_x / (1.33 * std::cos(out));
    const double tan = std::tan(in - out);
    return std::pair(tan, (1.0 + tan * tan) * (in_x - out_x));
  };
  const auto height = [=](double x) { return depth + 0.1 * std::sin(2 * kPi * x); };
  return Strips([=](double x) { return x + height(x) * refracted(x).first; },
                [=](double x) {
                  const auto [tan, tan_x] = refracted(x);
                  return 1.0 + 0.2 * kPi * std::cos(2 * kPi * x) * tan + height(x) * tan_x;
                },
                [](double) { return 1.0; }, -1.0, 2.0);
}

OpticalSystem water_waves(double depth) {
  const auto surface =
      geometry::make_expression(geometry::read_expression("z-0.1*sin(6.283185307179586*x)", 1.0),
                                {Point(-1, -1, -0.2), Point(2, 2, 0.2)}, {});
  auto water = test::mirror(surface.surface);
  water.optics = {.kind = Optics::Kind::refract, .index_outside = 1.0, .index_inside = 1.33};
  return OpticalSystem::build(CollimatedLight{{0, 0, -1}, 1.0}, {water},
                              floor_at({0.5, 0.5, -depth}, 1, 1));
}

TEST(Analysis, OfWaterWavesIsOneDimensional) {
  const std::vector<double> levels{0.8, 1.5, 3.0, 10.0};
  const Strips strips = strips_of_water(1.0);
  const double all = strips.above(1e-3, 0.0, 1.0).second;
  std::vector<std::pair<double, double>> expected;
  for (const double level : levels) expected.push_back(strips.above(level, 0.0, 1.0));
  for (const double chord : {1e-4, 1e-2}) {
    const auto analysis = analysis_of(water_waves(1.0), levels, chord);
    expect_holds(analysis.flux, all, 1e-8);
    for (std::size_t i = 0; i < levels.size(); ++i) {
      expect_holds(analysis.levels[i].area, expected[i].first, 1e-8);
      expect_holds(analysis.levels[i].flux, expected[i].second, 1e-8);
    }
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
                      [=](double p) { return std::cos(p) * reflectance(metal, p); }, -end, end);
  auto trough = test::mirror(geometry::make_cylinder(Point::Zero(), {0, 1, 0}, 1.0),
                             geometry::box_aperture({-0.6, -1, -1.1}, {0.6, 1, -0.5}));
  trough.optics.metal = metal;
  const auto system = OpticalSystem::build(CollimatedLight{{0, 0, -1}, 1.0}, {trough},
                                           floor_at({0, 0, kHeight}, 0.5, 0.5));
  const auto analysis = analysis_of(system, {3.0, 10.0}, 1e-3);
  expect_holds(analysis.flux, 0.5 * strips.above(1e-3, -0.25, 0.25).second, 1e-8);
  for (const LevelAnalysis& level : analysis.levels) {
    const auto [width, flux] = strips.above(level.level, -0.25, 0.25);
    EXPECT_GT(width, 0.0);
    expect_holds(level.area, 0.5 * width, 1e-8);
    expect_holds(level.flux, 0.5 * flux, 1e-8);
  }
}

// Before light has met: no caustic, and extremes along lines across.
TEST(Analysis, OfShallowWaterIsBounded) {
  const Strips strips = strips_of_water(0.4);
  double least = geometry::kInfinity, largest = 0.0;
  for (int i = 0; i <= 5000; ++i) {
    const double E = strips.irradiance(1e-9 + (1.0 - 2e-9) * i / 5000);
    least = std::min(least, E);
    largest = std::max(largest, E);
  }
  const auto analysis = analysis_of(water_waves(0.4), {0.9});
  EXPECT_FALSE(analysis.max.unbounded);
  // Samples are 2e-4 apart.
  EXPECT_NEAR(analysis.min.E.value, least, 1e-6);
  EXPECT_NEAR(analysis.max.E.value, largest, 1e-5);
  EXPECT_LE(analysis.min.E.value, least + analysis.min.E.error);
  EXPECT_GE(analysis.max.E.value, largest - analysis.max.E.error);
  for (const Extreme& extreme : {analysis.min, analysis.max}) {
    EXPECT_LE(extreme.E.error, 1e-9);
    expect_holds(extreme.E, strips.irradiance(extreme.q.x() + 0.5), 1e-9);
  }
}

// 10⁷ by ISOCAUSTIC_SAMPLES=10000000.
int analysis_samples() {
  const char* wanted = std::getenv("ISOCAUSTIC_SAMPLES");
  return wanted ? std::atoi(wanted) : 6000;
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
  const auto system = one_mirror(CollimatedLight{Vec3(1, 0, -1).normalized(), 1.0},
                                 geometry::make_cylinder(Point::Zero(), {0, 0, 1}, 1.0),
                                 floor_at({0.5, 0, 0}, 1.2, 1.2),
                                 geometry::box_aperture({0.5, -1, 0}, {1.001, 1, 1}));
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
  const Point lamp(0.1, 0.05, 1.0);
  const Vec3 normals[2] = {Vec3(0.2, 0, 1).normalized(), Vec3(-0.2, 0.05, 1).normalized()};
  const Point middles[2] = {{-0.5, 0, 0}, {0.5, 0, 0}};
  const geometry::Vec2 lo[2] = {{-0.8, -0.3}, {0.2, -0.25}}, hi[2] = {{-0.2, 0.3}, {0.8, 0.35}};
  std::vector<SystemSurface> plates;
  for (const int k : {0, 1}) {
    plates.push_back(
        test::mirror(geometry::make_plane(middles[k], normals[k]),
                     geometry::box_aperture({lo[k].x(), lo[k].y(), -1}, {hi[k].x(), hi[k].y(), 1}),
                     k == 0 ? 0.9 : 0.8));
  }
  plates[1].name = "right";
  const auto system =
      OpticalSystem::build(PointLight{lamp, 1.0}, plates, floor_at({0, 0, 1.5}, 3, 3));
  const auto analysis = analysis_of(system, {0.05, 0.09, 0.12});
  expect_what_random_points_say(system, analysis, [&](Random& random) {
    const int k = random.uniform(0.0, 1.0) < 0.5 ? 0 : 1;
    const Vec3& n = normals[k];
    Point x(random.uniform(lo[k].x(), hi[k].x()), random.uniform(lo[k].y(), hi[k].y()), 0.0);
    x.z() = -(n.x() * (x.x() - middles[k].x()) + n.y() * (x.y() - middles[k].y())) / n.z();
    const Vec3 d = x - lamp, out = d - 2.0 * d.dot(n) * n;
    const double tau = (1.5 - x.z()) / out.z();
    const double area = 2.0 * (hi[k] - lo[k]).prod() / n.z();
    const double weight = (k == 0 ? 0.9 : 0.8) * area * std::abs(d.dot(n)) / std::pow(d.norm(), 3);
    return std::pair(Vec2(x.x() + tau * out.x(), x.y() + tau * out.y()), weight);
  });
  // The largest total lies where both patches are: no reading is larger, and some come near.
  LightMeter meter(system, {}, false);
  double largest = 0.0;
  for (int j = 0; j < 100; ++j) {
    for (int i = 0; i < 100; ++i) {
      largest = std::max(largest, meter.at({0.03 * i - 1.485, 0.03 * j - 1.485}).E);
    }
  }
  EXPECT_GE(analysis.max.E.value + analysis.max.E.error, largest);
  EXPECT_LE(analysis.max.E.value, 1.05 * largest);
  // It is a corner of where they overlap, and read on one side of it only.
  double beside = 0.0;
  for (int k = 0; k < 16; ++k) {
    const double angle = 2.0 * kPi * k / 16.0;
    beside = std::max(beside,
                      meter.at(analysis.max.q + 1e-6 * Vec2(std::cos(angle), std::sin(angle))).E);
  }
  EXPECT_NEAR(beside, analysis.max.E.value, 1e-5);
  EXPECT_EQ(meter.at(analysis.min.q).E, 0.0);
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
  const auto system = OpticalSystem::build(
      PointLight{lamp, 2.0},
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
