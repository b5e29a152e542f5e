// The solver's time for a request, on one core, as ContourResult::seconds has it.
#include <benchmark/benchmark.h>

#include "tests/bench/scenes.h"

namespace caustic::bench {
namespace {

void contours(benchmark::State& state, SceneRequest scene) {
  const bool certify = scene.request.certify;
  const auto result = trace(state, std::move(scene));
  state.counters["curves"] = static_cast<double>(result.curves.size());
  if (!certify) return;
  state.counters["certified"] = result.certified;
  state.counters["cells"] = static_cast<double>(result.cells);
  state.counters["undecided"] = static_cast<double>(result.undecided_cells);
}

BENCHMARK_CAPTURE(contours, ellipsoid_bowl, example_scene("ellipsoid-bowl"));
BENCHMARK_CAPTURE(contours, convex_ellipsoid, convex_ellipsoid());
BENCHMARK_CAPTURE(contours, A1_sphere_ceiling, example_scene("sphere-ceiling"));
BENCHMARK_CAPTURE(contours, A2_sphere_wall, example_scene("sphere-wall"));
BENCHMARK_CAPTURE(contours, B_nephroid, example_scene("nephroid"));
BENCHMARK_CAPTURE(contours, B_nephroid_total, nephroid_total());
BENCHMARK_CAPTURE(contours, certified_nephroid, certified(example_scene("nephroid")));
BENCHMARK_CAPTURE(contours, certified_ball_ceiling, certified(example_scene("sphere-ceiling")));
BENCHMARK_CAPTURE(contours, certified_convex_ellipsoid, certified(convex_ellipsoid()));
BENCHMARK_CAPTURE(contours, certified_ellipsoid_bowl, certified(example_scene("ellipsoid-bowl")));
BENCHMARK_CAPTURE(contours, certified_dish, certified(spherical_dish()));
BENCHMARK_CAPTURE(contours, certified_paraboloid, certified(example_scene("paraboloid")));
BENCHMARK_CAPTURE(contours, certified_water, certified(example_scene("water")));
BENCHMARK_CAPTURE(contours, certified_zernike, certified(example_scene("zernike-mirror")));
BENCHMARK_CAPTURE(contours, certified_heights, certified(example_scene("freeform-heights")));
BENCHMARK_CAPTURE(contours, certified_cuboid, certified(example_scene("cuboid")));
BENCHMARK_CAPTURE(contours, certified_torus, certified(example_scene("torus")));
BENCHMARK_CAPTURE(contours, certified_vase, certified(example_scene("vase")));
BENCHMARK_CAPTURE(contours, proven_total_nephroid, certified_total("nephroid"));
BENCHMARK_CAPTURE(contours, proven_total_plane_mirror, certified_total("plane-mirror"));
BENCHMARK_CAPTURE(contours, proven_total_ball_ceiling, certified_total("sphere-ceiling"));
BENCHMARK_CAPTURE(contours, proven_total_ball_wall, certified_total("sphere-wall"));
BENCHMARK_CAPTURE(contours, proven_total_water, certified_total("water"));
BENCHMARK_CAPTURE(contours, proven_total_paraboloid, certified_total("paraboloid"));
BENCHMARK_CAPTURE(contours, proven_total_zernike, certified_total("zernike-mirror"));
BENCHMARK_CAPTURE(contours, proven_total_heights, certified_total("freeform-heights"));
BENCHMARK_CAPTURE(contours, torus, example_scene("torus"));
BENCHMARK_CAPTURE(contours, cuboid, example_scene("cuboid"));
BENCHMARK_CAPTURE(contours, vase, example_scene("vase"));

}  // namespace
}  // namespace caustic::bench
