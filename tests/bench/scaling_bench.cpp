// How the cost of a request grows: with the number of levels, of vertices, of surfaces, of bounces
// and of threads. Evaluations of the map repeat to the last digit; times are of one core but for
// the last.
// ./dev bench scaling makes a table and a picture of it.
#include <benchmark/benchmark.h>

#include <cmath>
#include <thread>

#include "tests/bench/scenes.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace caustic::bench {
namespace {

using namespace geometry;

void generous(solver::ContourRequest& request) {
  request.time_limit = 600.0;
  request.vertex_limit = 100'000'000;
}

void set_levels(SceneRequest& scene, int levels, double lowest, double factor) {
  scene.request.levels.values.clear();
  for (int i = 0; i < levels; ++i)
    scene.request.levels.values.push_back(lowest * std::pow(factor, (i + 0.5) / levels));
}

void grow(benchmark::State& state, SceneRequest scene) {
  generous(scene.request);
  const auto result = trace(state, std::move(scene));
  state.counters["curves"] = static_cast<double>(result.curves.size());
  state.counters["undecided"] = static_cast<double>(result.undecided_cells);
  if (!result.complete) state.SkipWithError("a limit cut it short");
}

// ---- Levels and vertices
// -------------------------------------------------------------------------

SceneRequest nephroid_with_levels(int levels) {
  SceneRequest scene = nephroid_total();
  scene.request.chord_tolerance = 1e-4 * scene.system.receiver().width();
  set_levels(scene, levels, 0.5, 16.0);
  return scene;
}
SceneRequest egg_with_levels(int levels) {
  SceneRequest scene = convex_ellipsoid();
  set_levels(scene, levels, 2e-3, 10.0);
  return scene;
}
void levels_total(benchmark::State& state) {
  grow(state, nephroid_with_levels(static_cast<int>(state.range(0))));
}
void levels_sheets(benchmark::State& state) {
  grow(state, egg_with_levels(static_cast<int>(state.range(0))));
}
BENCHMARK(levels_total)->Name("scaling/levels/total")->RangeMultiplier(2)->Range(1, 256);
BENCHMARK(levels_sheets)->Name("scaling/levels/sheets")->RangeMultiplier(2)->Range(1, 256);

// Chord tolerances of 1/n of the window.
void vertices(benchmark::State& state, SceneRequest scene) {
  scene.request.chord_tolerance =
      scene.system.receiver().width() / static_cast<double>(state.range(0));
  grow(state, std::move(scene));
}
void vertices_total(benchmark::State& state) { vertices(state, nephroid_with_levels(3)); }
void vertices_sheets(benchmark::State& state) { vertices(state, egg_with_levels(3)); }
BENCHMARK(vertices_total)
    ->Name("scaling/vertices/total")
    ->RangeMultiplier(10)
    ->Range(1000, 100'000'000);
BENCHMARK(vertices_sheets)
    ->Name("scaling/vertices/sheets")
    ->RangeMultiplier(10)
    ->Range(1000, 1'000'000'000);

// ---- Surfaces
// ------------------------------------------------------------------------------------

// n mirrors, each in a cell of a square of 2 m × 2 m that it fills to a fifth, a lamp 3 m above its
// middle and a ceiling of 6 m × 6 m at 4 m.
template <class Make>
SceneRequest field_of(int n, const Make& mirror_at) {
  const int side = static_cast<int>(std::lround(std::ceil(std::sqrt(n))));
  const double cell = 2.0 / side;
  test::Random random(3);
  std::vector<solver::SystemSurface> surfaces;
  for (int i = 0; i < n; ++i) {
    const Point place(cell * (i % side + 0.5) - 1.0, cell * (i / side + 0.5) - 1.0, 0.0);
    surfaces.push_back(mirror_at(place + random.in_cube(0.2 * cell), 0.2 * cell));
  }
  return {solver::OpticalSystem::build(solver::PointLight{{0, 0, 3}, 1.0}, std::move(surfaces),
                                       test::floor_at({0, 0, 4}, 6.0, 6.0)),
          {}};
}

solver::SystemSurface small_ball(const Point& place, double size) {
  return test::mirror(make_sphere(place, size));
}
// A square that sends the lamp's light to the middle of the ceiling.
solver::SystemSurface facet(const Point& place, double size) {
  const Direction normal =
      ((Point(0, 0, 3) - place).normalized() + (Point(0, 0, 4) - place).normalized()).normalized();
  return test::mirror(make_plane(place, normal),
                      box_aperture(place.array() - size, place.array() + size));
}

void surfaces_balls(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  SceneRequest scene = field_of(n, small_ball);
  scene.request.levels.count = 3;
  grow(state, std::move(scene));
}
void surfaces_facets(benchmark::State& state) {
  SceneRequest scene = field_of(static_cast<int>(state.range(0)), facet);
  scene.request.levels.count = 3;
  grow(state, std::move(scene));
}
BENCHMARK(surfaces_balls)->Name("scaling/surfaces/balls")->RangeMultiplier(10)->Range(1, 10'000);
BENCHMARK(surfaces_facets)->Name("scaling/surfaces/facets")->RangeMultiplier(10)->Range(1, 10'000);

// ---- Bounces
// -------------------------------------------------------------------------------------

// Between two plane mirrors, 1 m apart, from a lamp at one end to a screen at the other.
SceneRequest corridor() {
  const std::vector<Bound> here = box_aperture({-0.2, -1.5, -0.5}, {1.2, 1.5, 1.5});
  return {solver::OpticalSystem::build(
              solver::PointLight{{0, 0, 0.5}, 1.0},
              {test::mirror(make_plane({0, 0, 0}, {0, 0, 1}), here),
               test::mirror(make_plane({0, 0, 1}, {0, 0, -1}), here)},
              ReceiverFrame::make({1, 0, 0.5}, {0, 1, 0}, {0, 0, 1}, {2.0, 0.8})),
          {}};
}

// The family that begins below and goes to and fro.
void bounces_family(benchmark::State& state) {
  SceneRequest scene = corridor();
  std::vector<int> family;
  for (int i = 0; i < state.range(0); ++i) family.push_back(i % 2);
  scene.request.families = {family};
  grow(state, std::move(scene));
}
void bounces_all(benchmark::State& state) {
  SceneRequest scene = corridor();
  scene.request.max_bounces = static_cast<int>(state.range(0));
  scene.request.min_flux_share = 0.0;
  grow(state, std::move(scene));
}
BENCHMARK(bounces_family)->Name("scaling/bounces/one family")->DenseRange(1, 8);
BENCHMARK(bounces_all)->Name("scaling/bounces/all up to")->DenseRange(1, 8);

// ---- Threads
// -------------------------------------------------------------------------------------

// The curves of one request's sheets are shared out to its threads; the service gives it one.
void threads_of_request(benchmark::State& state) {
  SceneRequest scene = example_scene("torus");
  generous(scene.request);
  scene.request.chord_tolerance = 1e-7 * scene.system.receiver().width();
  scene.request.threads = static_cast<int>(state.range(0));
  Samples samples;
  for (auto _ : state) samples.add(solver::trace_contours(scene.system, scene.request).seconds);
  samples.report_milliseconds(state);
}
// As many requests at once as threads: time for each of them.
void threads_requests(benchmark::State& state) {
  SceneRequest scene = example_scene("torus");
  const int requests = static_cast<int>(state.range(0));
  Samples samples;
  for (auto _ : state) {
    samples.time([&] {
      std::vector<std::thread> threads;
      for (int i = 0; i < requests; ++i) {
        threads.emplace_back([&] {
          for (int k = 0; k < 4; ++k) solver::trace_contours(scene.system, scene.request);
        });
      }
      for (std::thread& thread : threads) thread.join();
    });
  }
  samples.report_milliseconds(state);
  state.counters["min_ms"] = 1e3 * samples.min() / (4.0 * requests);
}
BENCHMARK(threads_of_request)->Name("scaling/threads/one request")->DenseRange(1, 2)->UseRealTime();
BENCHMARK(threads_requests)
    ->Name("scaling/threads/requests at once")
    ->DenseRange(1, 2)
    ->UseRealTime();

}  // namespace
}  // namespace caustic::bench
