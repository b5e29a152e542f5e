// Scenes that several benchmarks share.
#pragma once

#include <benchmark/benchmark.h>

#include <string_view>

#include "service/api/contour_json.h"
#include "service/examples/examples.h"
#include "solver/contours.h"
#include "tests/bench/samples.h"

namespace caustic::bench {

struct SceneRequest {
  solver::OpticalSystem system;
  solver::ContourRequest request;
};

/// Traces it for as long as the state wants, on one core, by ContourResult::seconds.
inline solver::ContourResult trace(benchmark::State& state, SceneRequest scene) {
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
  state.counters["vertices"] = static_cast<double>(vertices);
  state.counters["evaluations"] = static_cast<double>(result.evaluations);
  state.counters["us_per_vertex"] = 1e6 * samples.min() / static_cast<double>(vertices);
  return result;
}

/// One of service/examples/, sheet by sheet.
inline SceneRequest example_scene(std::string_view name) {
  service::ContourCall call = service::read_contour_call(service::find_example(name)->body);
  call.request.measure = solver::Measure::sheet;
  return {std::move(call.system), std::move(call.request)};
}

/// The nephroid's total, chord 1e-5 of the window.
inline SceneRequest nephroid_total() {
  SceneRequest scene = example_scene("nephroid");
  scene.request.measure = solver::Measure::total;
  scene.request.chord_tolerance = 1e-5 * scene.system.receiver().width();
  return scene;
}

/// The same with the proof that no curve is missed.
inline SceneRequest certified(SceneRequest scene) {
  scene.request.certify = true;
  scene.request.time_limit = 60.0;
  return scene;
}

inline SceneRequest certified_total(const char* example) {
  SceneRequest scene = certified(example_scene(example));
  scene.request.measure = solver::Measure::total;
  return scene;
}

/// A spherical dish 1.2 m wide, tilted, in a beam, and its caustic on a screen of 0.6 m; eight
/// levels.
inline SceneRequest spherical_dish() {
  using namespace geometry;
  const Direction tilt = Vec3(0.2, 0.1, -1.0).normalized();
  SceneRequest scene{solver::OpticalSystem::build(
                         solver::CollimatedLight{tilt, 1.0},
                         {{"dish",
                           make_sphere({0, 0, 1}, 1.0),
                           {cylinder_aperture({0, 0, 0}, Vec3::UnitZ(), 0.6),
                            half_space_aperture({0, 0, 0.5}, Vec3::UnitZ())},
                           {}}},
                         ReceiverFrame::make({0.1, 0.05, 0.45}, {1, 0, 0}, {0, 1, 0}, {0.6, 0.6})),
                     {}};
  return scene;
}

/// A convex mirror, semi-axes 1, 1.4 and 0.8 m, under a lamp, and a ceiling of 6 m × 6 m; ten
/// levels.
inline SceneRequest convex_ellipsoid() {
  using namespace geometry;
  SceneRequest scene{
      solver::OpticalSystem::build(
          solver::PointLight{{1.0, 0.5, 3.0}, 1.0},
          {{"egg", make_ellipsoid(Point::Zero(), {1.0, 1.4, 0.8}, Mat3::Identity()), {}, {}}},
          ReceiverFrame::make({0, 0, 4}, {1, 0, 0}, {0, 1, 0}, {6, 6})),
      {}};
  scene.request.levels.count = 10;
  return scene;
}

}  // namespace caustic::bench
