// All paths of a single-mirror family from one light to points of one receiver, after one set-up,
// and the questions that are asked once.
#include <benchmark/benchmark.h>

#include <chrono>

#include "solver/paths_between.h"
#include "solver/point_irradiance.h"
#include "tests/bench/samples.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace caustic::bench {
namespace {

using geometry::Vec2;
using solver::OpticalSystem;

constexpr int kReceiverPoints = 10000;

OpticalSystem scene(geometry::SurfacePtr shape, const geometry::Point& light, double height) {
  return test::one_mirror(solver::PointLight{light, 1.0}, std::move(shape),
                          test::floor_at({0, 0, height}, 3.0, 3.0));
}
OpticalSystem ball() { return scene(geometry::make_sphere({0, 0, 0}, 1.0), {0.3, 0.2, 4}, 3.0); }
OpticalSystem bowl() {
  return scene(geometry::make_ellipsoid({0, 0, 0}, {2.6, 2.2, 3.0}, geometry::Mat3::Identity()),
               {0.3, 0.2, 0.5}, -1.0);
}
OpticalSystem torus() {
  return scene(geometry::make_torus({0, 0, 0}, {0, 0, 1}, 1.5, 0.5), {0.3, 0.2, 2.5}, 3.0);
}

std::vector<geometry::Point> places(const OpticalSystem& system) {
  test::Random random(1);
  std::vector<geometry::Point> points;
  const Vec2 half = system.receiver().half;
  for (int k = 0; k < kReceiverPoints; ++k) {
    const double u = random.uniform(-1, 1), v = random.uniform(-1, 1);
    points.push_back(system.receiver().point({u * half.x(), v * half.y()}));
  }
  return points;
}

// Microseconds for all paths to one point, the finder being new at the first of them.
void paths_to_points(benchmark::State& state, OpticalSystem (*make)()) {
  const OpticalSystem system = make();
  const auto points = places(system);
  double best = 1e30;
  std::size_t paths = 0;
  for (auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    solver::PathFinder finder(system, {0}, system.light());
    paths = 0;
    for (const auto& p : points) paths += finder.to(p).paths.size();
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
    best = std::min(best, time.count());
  }
  state.counters["us_per_point"] = 1e6 * best / kReceiverPoints;
  state.counters["paths_per_point"] = static_cast<double>(paths) / kReceiverPoints;
}
BENCHMARK_CAPTURE(paths_to_points, ball, ball)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(paths_to_points, bowl, bowl)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(paths_to_points, torus, torus)->Unit(benchmark::kMillisecond);

void irradiance_at_points(benchmark::State& state, OpticalSystem (*make)()) {
  const OpticalSystem system = make();
  const auto points = places(system);
  for (auto _ : state) {
    solver::LightMeter meter(system, {}, true);
    for (const auto& p : points) {
      const geometry::Vec3 y = p - system.receiver().origin;
      benchmark::DoNotOptimize(
          meter.at({system.receiver().u.dot(y), system.receiver().v.dot(y)}).E);
    }
  }
}
BENCHMARK_CAPTURE(irradiance_at_points, ball, ball)->Unit(benchmark::kMillisecond);

void paths_once(benchmark::State& state, OpticalSystem (*make)(), bool certify) {
  const OpticalSystem system = make();
  const auto points = places(system);
  solver::PathsRequest request;
  request.from = std::get<solver::PointLight>(system.light()).position;
  request.certify = certify;
  std::size_t k = 0;
  for (auto _ : state) {
    request.to = points[k++ % points.size()];
    benchmark::DoNotOptimize(solver::paths_between(system, request).paths.size());
  }
}
BENCHMARK_CAPTURE(paths_once, bowl, bowl, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(paths_once, bowl_certified, bowl, true)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(paths_once, torus_certified, torus, true)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace caustic::bench
