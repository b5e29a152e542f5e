// What irradiance with its gradient costs against the bare map x ↦ q, the first hit being known.
// Both are timed in turns, so that a busy machine slows both; "ratio" is that of the minima.
#include "solver/forward_map.h"

#include <benchmark/benchmark.h>

#include "geometry/surface.h"
#include "tests/bench/samples.h"
#include "tests/support/random.h"

namespace caustic::bench {
namespace {

using namespace geometry;

constexpr int kMirrorPoints = 256;

const Direction kTilted = Direction(0.1, -0.2, 1.0).normalized();

void forward_map(benchmark::State& state, const SurfacePtr& shape) {
  const auto system = solver::OpticalSystem::build(
      solver::PointLight{{0.6, 0.5, 3.0}, 1.0}, {{"mirror", shape, {}, {}}},
      ReceiverFrame::make({0, 0, 4}, {1, 0.1, 0}, {0, 1, 0}, {6, 6}));
  const solver::ForwardMap map(system, 0, 1);
  test::Random random(1);
  std::vector<Point> points;
  for (int i = 0; i < kMirrorPoints; ++i) {
    points.push_back(map.project(Point(0.0, 0.0, 0.5) + random.in_cube(0.4)));
  }
  Samples evaluate, arrival;
  for (auto _ : state) {
    arrival.time([&] {
      for (const Point& x : points) benchmark::DoNotOptimize(map.arrival(x));
    });
    evaluate.time([&] {
      for (const Point& x : points) benchmark::DoNotOptimize(map.evaluate(x));
    });
  }
  state.counters["arrival_ns"] = 1e9 * arrival.min() / kMirrorPoints;
  state.counters["evaluate_ns"] = 1e9 * evaluate.min() / kMirrorPoints;
  state.counters["ratio"] = evaluate.min() / arrival.min();
}

BENCHMARK_CAPTURE(forward_map, plane, make_plane(Point(0, 0, 0.5), kTilted));
BENCHMARK_CAPTURE(forward_map, sphere, make_sphere(Point::Zero(), 1.0));
BENCHMARK_CAPTURE(forward_map, ellipsoid,
                  make_ellipsoid(Point::Zero(), {1.0, 1.4, 0.8}, Mat3::Identity()));
BENCHMARK_CAPTURE(forward_map, torus, make_torus(Point::Zero(), kTilted, 1.0, 0.4));
BENCHMARK_CAPTURE(forward_map, asphere,
                  make_conic(Point::Zero(), kTilted, 2.0, -0.8, {0.01, -0.002}));

}  // namespace
}  // namespace caustic::bench
