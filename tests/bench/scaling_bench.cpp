// How the cost of a total grows: with the number of levels, and with that of vertices. Evaluations
// of the map repeat to the last digit; times are of one core.
#include <benchmark/benchmark.h>

#include <cmath>

#include "tests/bench/scenes.h"

namespace caustic::bench {
namespace {

void total_of_nephroid(benchmark::State& state, int levels, double chord_share) {
  SceneRequest scene = nephroid_total();
  scene.request.time_limit = 60.0;
  scene.request.chord_tolerance = chord_share * scene.system.receiver().width();
  scene.request.levels.values.clear();
  for (int i = 0; i < levels; ++i)
    scene.request.levels.values.push_back(0.5 * std::pow(16.0, (i + 0.5) / levels));
  const auto result = trace(state, std::move(scene));
  state.counters["undecided"] = static_cast<double>(result.undecided_cells);
}

void scaling_levels(benchmark::State& state) {
  total_of_nephroid(state, static_cast<int>(state.range(0)), 1e-4);
}
BENCHMARK(scaling_levels)->RangeMultiplier(2)->Range(1, 64);

// Chord tolerances of 1/n of the window.
void scaling_vertices(benchmark::State& state) {
  total_of_nephroid(state, 3, 1.0 / static_cast<double>(state.range(0)));
}
BENCHMARK(scaling_vertices)->RangeMultiplier(10)->Range(1000, 10'000'000);

}  // namespace
}  // namespace caustic::bench
