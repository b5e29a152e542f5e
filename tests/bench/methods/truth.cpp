#include "tests/bench/methods/truth.h"

namespace caustic::bench {

namespace {

// Samples a width. A chord is farthest from its arc in its middle, one of five; the truth's chords
// are arcs already.
constexpr double kSamples = 2000;
constexpr int kOfAChord = 5, kOfTheTruth = 1;

}  // namespace

Truth make_truth(const Scene& scene, solver::Measure measure) {
  auto request = request_of(scene, measure, scene.truth_chord);
  request.irradiance_tolerance = 1e-12;
  Truth truth{solver::trace_contours(scene.system, request), {}, {}, {}};
  truth.lines.resize(scene.levels.size());
  truth.kinds.resize(scene.levels.size());
  for (const auto& curve : truth.result.curves) {
    if (!is_drawn(curve)) continue;
    const std::size_t k = level_of(scene, curve.level);
    truth.lines[k].push_back(line_of(curve));
    truth.kinds[k].push_back(curve.kind == solver::CurveKind::jump ? kJump : kLevelArc);
  }
  for (const auto& lines : truth.lines) truth.nearest.emplace_back(lines);
  return truth;
}

DrawingError error_of(const Scene& scene, const Truth& truth, const Drawing& drawing) {
  const double width = scene.width();
  DrawingError error;
  const auto add = [&](int kind, test::CurveDistance d) {
    d.max /= width;
    d.sum /= width;
    error.all.add(d);
    if (kind == kLevelArc) error.level_arcs.add(d);
  };
  for (std::size_t k = 0; k < scene.levels.size(); ++k) {
    const auto there = test::distances(drawing.levels[k], truth.nearest[k], truth.kinds[k],
                                       kLineKinds, {width / kSamples, kOfAChord}, width);
    for (int kind = 0; kind < kLineKinds; ++kind) add(kind, there[kind]);
    const test::NearestOnLines drawn(drawing.levels[k]);
    const std::vector<int> alike(drawing.levels[k].size(), 0);
    for (std::size_t i = 0; i < truth.lines[k].size(); ++i)
      add(truth.kinds[k][i], test::distances({truth.lines[k][i]}, drawn, alike, 1,
                                             {width / kSamples, kOfTheTruth}, width)[0]);
  }
  return error;
}

}  // namespace caustic::bench
