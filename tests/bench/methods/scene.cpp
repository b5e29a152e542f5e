#include "tests/bench/methods/scene.h"

#include <map>
#include <stdexcept>

#include "service/api/contour_json.h"
#include "service/examples/examples.h"
#include "solver/contours.h"

namespace caustic::bench {

namespace {

const std::map<std::string, std::string> kExamples{{"A1", "sphere-ceiling"}, {"A2", "sphere-wall"},
                                                   {"B", "nephroid"},        {"C1", "water"},
                                                   {"cuboid", "cuboid"},     {"vase", "vase"}};

}  // namespace

const std::vector<std::string>& scene_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    all.reserve(kExamples.size());
    for (const auto& [name, example] : kExamples) all.push_back(name);
    return all;
  }();
  return names;
}

Scene make_scene(const std::string& name) {
  const auto found = kExamples.find(name);
  if (found == kExamples.end()) throw std::invalid_argument("no scene \"" + name + "\"");
  auto call = service::read_contour_call(service::find_example(found->second)->body);
  call.request.measure = solver::Measure::sheet;
  call.request.caustic = false;
  call.request.time_limit = 60.0;
  const auto sheets = solver::trace_contours(call.system, call.request);
  // Finer than that, occlusions of the other two are not resolved (README).
  const bool fine = name != "cuboid" && name != "vase";
  Scene scene{name, found->second,       std::move(call.system), sheets.levels,
              {},   fine ? 1e-10 : 1e-8, name[0] == 'A'};
  for (const auto& curve : sheets.curves) {
    const auto at = std::find(sheets.levels.begin(), sheets.levels.end(), curve.level);
    scene.seeds.push_back({static_cast<std::size_t>(at - sheets.levels.begin()),
                           curve.vertices[curve.vertices.size() / 2].x});
  }
  return scene;
}

}  // namespace caustic::bench
