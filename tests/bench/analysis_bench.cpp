// The solver's time for an analysis, on one core, and the largest of its errors.
#include "solver/analysis.h"

#include <benchmark/benchmark.h>

#include <algorithm>

#include "tests/bench/samples.h"
#include "tests/bench/scenes.h"

namespace caustic::bench {
namespace {

void analysis(benchmark::State& state, SceneRequest scene) {
  Samples samples;
  solver::Analysis result;
  for (auto _ : state) {
    samples.time([&] { result = solver::analyse(scene.system, scene.request); });
  }
  double area_error = 0.0, flux_error = result.flux.error;
  for (const solver::LevelAnalysis& level : result.levels) {
    area_error = std::max(area_error, level.area.error);
    flux_error = std::max(flux_error, level.flux.error);
  }
  const auto& half = scene.system.receiver().half;
  samples.report_milliseconds(state);
  state.counters["levels"] = static_cast<double>(result.levels.size());
  state.counters["area_error"] = area_error / (4.0 * half.x() * half.y());
  state.counters["flux_error"] = flux_error / result.flux.value;
  state.counters["undecided"] = static_cast<double>(result.undecided);
}

BENCHMARK_CAPTURE(analysis, A1_sphere_ceiling, example_scene("sphere-ceiling"));
BENCHMARK_CAPTURE(analysis, B_nephroid, example_scene("nephroid"));
BENCHMARK_CAPTURE(analysis, water, example_scene("water"));
BENCHMARK_CAPTURE(analysis, two_mirrors, example_scene("two-mirrors"));
BENCHMARK_CAPTURE(analysis, zernike_mirror, example_scene("zernike-mirror"));
BENCHMARK_CAPTURE(analysis, vase, example_scene("vase"));

}  // namespace
}  // namespace caustic::bench
