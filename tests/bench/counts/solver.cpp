// The parts of a request, on three fields: a convex ellipsoid (nothing can be hidden), the bowl (an
// open mirror, which may hide its own light) and the torus (a quartic that does).
#include <algorithm>
#include <cmath>

#include "solver/contour_task.h"
#include "solver/paths_between.h"
#include "tests/bench/counts/subject.h"
#include "tests/bench/scenes.h"
#include "tests/support/random.h"

namespace caustic::bench {
namespace {

using solver::FamilyField;

constexpr double kHour = 3600.0, kMargin = 1e-2, kResidualAimedAt = 1e-10;
constexpr std::size_t kAnyNumber = std::size_t{1} << 40;

// The brightest family of a request, which explores, seeds and traces.
class Stage {
 public:
  explicit Stage(SceneRequest made)
      : scene_(std::make_shared<const SceneRequest>(std::move(made))),
        plan_(solver::make_plan(scene_->system, {{0}}, false, {})) {}

  std::shared_ptr<FamilyField> explored() const {
    std::shared_ptr<FamilyField> best;
    for (const solver::PlannedPiece& piece : plan_.pieces) {
      // The field refers to the system, which must stay.
      std::shared_ptr<FamilyField> field(
          new FamilyField(scene_->system, piece, nullptr, kMargin * scene_->system.diameter()),
          [scene = scene_](FamilyField* f) { delete f; });
      solver::Budget budget(kHour, kAnyNumber, nullptr);
      field->explore(budget);
      if (!best || field->flux > best->flux) best = std::move(field);
    }
    return best;
  }
  std::vector<solver::ContourTask> tasks(FamilyField& field) const {
    const auto levels = solver::resolve_levels(scene_->request.levels, field.samples);
    std::vector<solver::LevelFunction> functions;
    std::vector<solver::ContourTask> tasks;
    for (const int parity : {1, -1}) {
      for (const double level : levels)
        functions.push_back(solver::LevelFunction::isolux(level, parity));
    }
    std::sort(functions.begin(), functions.end(),
              [](const auto& a, const auto& b) { return a.k < b.k; });
    for (const auto& f : functions)
      tasks.push_back({&field, f, 1.0 / std::abs(f.k), {}, true, {}, 0});
    solver::Budget budget(kHour, kAnyNumber, nullptr);
    solver::Evaluator evaluate(field.map, budget);
    for (auto& seed : find_seeds(evaluate, field.exploration, field.critical, functions))
      tasks[seed.target].seeds.push_back(std::move(seed));
    return tasks;
  }
  double chord() const { return 1e-4 * scene_->system.receiver().width(); }

 private:
  std::shared_ptr<const SceneRequest> scene_;
  solver::Plan plan_;
};

Work subdivision(SceneRequest scene) {
  const Stage stage(std::move(scene));
  return {[=] { keep(stage.explored()->flux); }, stage.explored()->exploration.cells.size()};
}

std::size_t trace_all(const Stage& stage, std::vector<solver::ContourTask> tasks) {
  solver::Budget budget(kHour, kAnyNumber, nullptr);
  std::size_t vertices = 0;
  for (solver::ContourTask& task : tasks) {
    run(task, budget, stage.chord(), kResidualAimedAt);
    for (const solver::Trace& trace : task.traces) vertices += trace.vertices.size();
  }
  return vertices;
}

Work tracing(SceneRequest scene) {
  const Stage stage(std::move(scene));
  const auto field = stage.explored();
  const auto tasks = stage.tasks(*field);
  return {[=] { keep(trace_all(stage, tasks)), keep(field); }, trace_all(stage, tasks)};
}

struct FieldOf {
  const char* name;
  SceneRequest (*make)();
};
const FieldOf kFields[] = {{"ellipsoid", convex_ellipsoid},
                           {"bowl", [] { return example_scene("ellipsoid-bowl"); }},
                           {"torus", [] { return example_scene("torus"); }}};

// All paths to points of the receiver, the finder being new.
Work paths_to_points(const SceneRequest& scene) {
  constexpr int kPlaces = 500;
  const auto system = std::make_shared<solver::OpticalSystem>(scene.system);
  const geometry::ReceiverFrame& receiver = system->receiver();
  test::Random random(1);
  std::vector<geometry::Point> places;
  for (int k = 0; k < kPlaces; ++k) {
    const double u = random.uniform(-1, 1), v = random.uniform(-1, 1);
    places.push_back(receiver.point({u * receiver.half.x(), v * receiver.half.y()}));
  }
  return {[=] {
            solver::PathFinder finder(*system, {0}, system->light());
            for (const auto& p : places) keep(finder.to(p).paths);
          },
          kPlaces};
}

}  // namespace

void add_solver(Subjects& subjects) {
  for (const auto& [name, make] : kFields) {
    const std::string of = std::string("/") + name;
    subjects.push_back({"subdivision" + of, "cells", [=] { return subdivision(make()); }});
    subjects.push_back({"tracing" + of, "vertices", [=] { return tracing(make()); }});
    subjects.push_back({"paths" + of, "places", [=] { return paths_to_points(make()); }});
  }
}

}  // namespace caustic::bench
