// The solver's time for a request, on one core, as ContourResult::seconds has it.
#include <benchmark/benchmark.h>

#include "tests/bench/samples.h"
#include "tests/bench/scenes.h"

namespace caustic::bench {
namespace {

void contours(benchmark::State& state, SceneRequest scene) {
  scene.request.threads = 1;
  Samples samples;
  solver::ContourResult result;
  for (auto _ : state) {
    result = solver::trace_contours(scene.system, scene.request);
    samples.add(result.seconds);
  }
  std::size_t vertices = 0;
  for (const solver::Curve& curve : result.curves) vertices += curve.vertices.size();
  samples.report_milliseconds(state);
  state.counters["curves"] = static_cast<double>(result.curves.size());
  state.counters["vertices"] = static_cast<double>(vertices);
  state.counters["evaluations"] = static_cast<double>(result.evaluations);
  state.counters["us_per_vertex"] = 1e6 * samples.min() / static_cast<double>(vertices);
}

BENCHMARK_CAPTURE(contours, ellipsoid_bowl, example_scene("ellipsoid-bowl"));
BENCHMARK_CAPTURE(contours, convex_ellipsoid, convex_ellipsoid());
BENCHMARK_CAPTURE(contours, A1_sphere_ceiling, example_scene("sphere-ceiling"));
BENCHMARK_CAPTURE(contours, A2_sphere_wall, example_scene("sphere-wall"));
BENCHMARK_CAPTURE(contours, B_nephroid, example_scene("nephroid"));
BENCHMARK_CAPTURE(contours, B_nephroid_total, nephroid_total());
BENCHMARK_CAPTURE(contours, torus, example_scene("torus"));
BENCHMARK_CAPTURE(contours, cuboid, example_scene("cuboid"));
BENCHMARK_CAPTURE(contours, vase, example_scene("vase"));

}  // namespace
}  // namespace caustic::bench
