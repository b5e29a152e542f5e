// 1: this program, by its chord tolerance.
#include "tests/bench/methods/ours.h"

#include <algorithm>

namespace caustic::bench {

solver::ContourRequest request_of(const Scene& scene, solver::Measure measure, double chord) {
  solver::ContourRequest request;
  request.levels.values = scene.levels;
  request.measure = measure;
  request.caustic = false;
  request.chord_tolerance = chord * scene.width();
  request.time_limit = 3600.0;
  request.vertex_limit = 20'000'000;
  return request;
}

test::Line line_of(const solver::Curve& curve) {
  test::Line line;
  line.reserve(curve.vertices.size() + 1);
  for (const auto& v : curve.vertices) line.push_back(v.uv);
  if (curve.closed) line.push_back(line.front());
  return line;
}

std::size_t level_of(const Scene& scene, double level) {
  return std::find(scene.levels.begin(), scene.levels.end(), level) - scene.levels.begin();
}

namespace {

Drawing draw_ours(const Scene& scene, solver::Measure measure, double chord) {
  const auto result = solver::trace_contours(scene.system, request_of(scene, measure, chord));
  Drawing drawing{std::vector<std::vector<test::Line>>(scene.levels.size()), result.evaluations,
                  result.complete ? "" : "incomplete"};
  for (const auto& curve : result.curves)
    if (is_drawn(curve)) drawing.levels[level_of(scene, curve.level)].push_back(line_of(curve));
  return drawing;
}

}  // namespace

std::vector<Method> our_methods() {
  // The farthest is at 0.8 of the chord allowed: a little less than a power of ten.
  const std::vector<double> chords{1.2e-2, 1.2e-3, 1.2e-4, 1.2e-5, 1.2e-6, 1.2e-7, 1.2e-8, 1.2e-9};
  std::vector<Method> methods;
  for (const auto& [name, measure] : {std::pair("ours", solver::Measure::total),
                                      std::pair("ours, sheets", solver::Measure::sheet)}) {
    methods.push_back(
        {name, measure, chords, [measure = measure](const Scene& scene, double chord) {
           return draw_ours(scene, measure, chord);
         }});
  }
  return methods;
}

}  // namespace caustic::bench
