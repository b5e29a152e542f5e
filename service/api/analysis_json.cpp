#include "service/api/analysis_json.h"

#include <nlohmann/json.hpp>

#include "service/api/family_json.h"
#include "service/api/json_text.h"
#include "service/api/level_json.h"
#include "service/api/scene_json.h"

namespace caustic::service {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;
using solver::Estimate;

ordered_json estimate_json(const Estimate& of, double unit = 1.0) {
  return {{"value", of.value / unit}, {"error", of.error / unit}};
}

}  // namespace

AnalysisCall read_analysis_call(std::string_view body) {
  json document = parse_json(body);
  Faults faults;
  Scene scene;
  solver::ContourRequest request;
  {
    ObjectReader root({&document, ""}, faults);
    if (const auto place = root.member("scene")) scene = read_scene(*place, faults);
    FamilyRequest families = read_families(root, scene);
    request.families = std::move(families.listed);
    request.max_bounces = families.max_bounces;
    request.min_flux_share = families.min_flux_share;
    request.levels = read_levels(root);
    if (root.boolean_or("direct", false))
      faults.not_supported(root.pointer_to("direct"), "the direct light");
  }
  faults.throw_if_any();
  return {solver::OpticalSystem::build(scene.light, std::move(scene.surfaces), scene.receiver),
          std::move(request), scene.units};
}

std::string analysis_answer(const AnalysisCall& call, const solver::Analysis& analysis) {
  if (analysis.unsupported) {
    Faults faults;
    faults.not_supported("/scene", *analysis.unsupported);
    faults.throw_if_any();
  }
  const double metres = call.units.length.metres;
  auto levels = ordered_json::array(), warnings = ordered_json::array();
  for (const solver::LevelAnalysis& level : analysis.levels) {
    levels.push_back({{"level", level.level},
                      {"area", estimate_json(level.area, metres * metres)},
                      {"flux", estimate_json(level.flux)}});
  }
  for (const auto& [code, detail] : analysis.warnings)
    warnings.push_back({{"code", code}, {"detail", detail}});
  return write_json(ordered_json{
      {"flux", estimate_json(analysis.flux)},
      {"E_avg", estimate_json(analysis.average)},
      {"levels", std::move(levels)},
      {"completeness", {{"certified", false}, {"undecided_cells", analysis.undecided}}},
      {"warnings", std::move(warnings)}});
}

}  // namespace caustic::service
