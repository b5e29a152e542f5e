// Is Embree worth its while, and from how many surfaces on (kEmbreeSurfaces)? And what the plan
// saves where nothing can be hidden.
#include "solver/visibility.h"

#include <benchmark/benchmark.h>

#include <cmath>

#include "tests/bench/samples.h"
#include "tests/bench/scenes.h"
#include "tests/support/random.h"

namespace caustic::bench {
namespace {

using namespace geometry;

// The convex ellipsoid's scene with n small balls between it and the receiver.
solver::OpticalSystem with_blockers(const SceneRequest& scene, int n) {
  test::Random random(7);
  auto surfaces = scene.system.surfaces();
  for (int i = 0; i < n; ++i) {
    const Point center = Point(0.0, 0.0, 2.2) + random.in_cube(1.0).cwiseProduct(Vec3(2, 2, 0.8));
    surfaces.push_back({"ball", make_sphere(center, 0.2 / std::sqrt(n)), {}, {}});
    surfaces.back().optics.kind = solver::Optics::Kind::absorb;
  }
  return solver::OpticalSystem::build(scene.system.light(), surfaces, scene.system.receiver());
}

// One question for a point of a curve, without and with Embree. Argument: number of blockers.
void visibility(benchmark::State& state) {
  const SceneRequest scene = convex_ellipsoid();
  const auto system = with_blockers(scene, static_cast<int>(state.range(0)));
  const double margin = 1e-2 * system.diameter();
  const solver::ForwardMap map(system, 0, 1);
  std::vector<solver::LightPath> paths;
  for (const auto& curve : solver::trace_contours(scene.system, scene.request).curves) {
    for (const auto& v : curve.vertices) paths.push_back({map, v.x, nullptr, v.p});
  }
  std::vector<Box> boxes;
  for (const auto& surface : system.surfaces()) boxes.push_back(surface.region);

  Samples each, embree, build;
  int differ = 0;
  for (auto _ : state) {
    std::unique_ptr<EmbreeScene> candidates;
    build.time([&] { candidates = std::make_unique<EmbreeScene>(boxes, margin); });
    const solver::Visibility by_each(system, nullptr, margin),
        by_embree(system, candidates.get(), margin);
    std::vector<bool> a, b;
    each.time([&] {
      for (const auto& path : paths) a.push_back(by_each.hidden(map.hops(), path));
    });
    embree.time([&] {
      for (const auto& path : paths) b.push_back(by_embree.hidden(map.hops(), path));
    });
    differ += a != b;
  }
  if (differ) state.SkipWithError("Embree and asking each surface disagree");
  const auto n = static_cast<double>(paths.size());
  state.counters["each_ns"] = 1e9 * each.min() / n;
  state.counters["embree_ns"] = 1e9 * embree.min() / n;
  state.counters["build_us"] = 1e6 * build.min();
}
BENCHMARK(visibility)
    ->Arg(4)
    ->Arg(8)
    ->Arg(12)
    ->Arg(16)
    ->Arg(24)
    ->Arg(32)
    ->Arg(64)
    ->Arg(250)
    ->Arg(1000);

// A whole request with many blockers, Embree left out or not: the threshold for the plan.
void blocked_contours(benchmark::State& state) {
  SceneRequest scene = convex_ellipsoid();
  const auto system = with_blockers(scene, static_cast<int>(state.range(0)));
  solver::ContourRequest forced = scene.request;
  forced.no_skip = {"embree"};
  Samples planned, embree;
  for (auto _ : state) {
    planned.add(solver::trace_contours(system, scene.request).seconds);
    embree.add(solver::trace_contours(system, forced).seconds);
  }
  state.counters["planned_ms"] = 1e3 * planned.min();
  state.counters["embree_ms"] = 1e3 * embree.min();
}
BENCHMARK(blocked_contours)
    ->Arg(4)
    ->Arg(12)
    ->Arg(22)
    ->Arg(23)
    ->Arg(64)
    ->Unit(benchmark::kMillisecond);

bool same_curves(const solver::ContourResult& a, const solver::ContourResult& b) {
  if (a.curves.size() != b.curves.size()) return false;
  for (std::size_t i = 0; i < a.curves.size(); ++i) {
    const auto &u = a.curves[i].vertices, &v = b.curves[i].vertices;
    const auto same = [](const auto& p, const auto& q) { return p.x == q.x && p.uv == q.uv; };
    if (!std::equal(u.begin(), u.end(), v.begin(), v.end(), same)) return false;
  }
  return true;
}

// One convex mirror: visibility left out by the plan, or asked all the same.
void plan(benchmark::State& state) {
  SceneRequest scene = convex_ellipsoid();
  solver::ContourRequest forced = scene.request;
  forced.no_skip = {"visibility"};
  Samples skipped, asked;
  solver::ContourResult a, b;
  for (auto _ : state) {
    a = solver::trace_contours(scene.system, scene.request);
    b = solver::trace_contours(scene.system, forced);
    skipped.add(a.seconds);
    asked.add(b.seconds);
  }
  if (!same_curves(a, b)) state.SkipWithError("the plan changes the curves");
  state.counters["skipped_ms"] = 1e3 * skipped.min();
  state.counters["asked_ms"] = 1e3 * asked.min();
}
BENCHMARK(plan)->Name("plan/convex_ellipsoid")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace caustic::bench
