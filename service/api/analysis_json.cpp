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

ordered_json extreme_json(const solver::Extreme& of, double metres) {
  return {
      {"value", of.E.value}, {"error", of.E.error}, {"uv", {of.q.x() / metres, of.q.y() / metres}}};
}

ordered_json max_json(const solver::Extreme& max, double metres) {
  ordered_json out = extreme_json(max, metres);
  if (max.unbounded) out["value"] = out["error"] = nullptr;
  out["unbounded"] = max.unbounded;
  return out;
}

ordered_json ratio_json(const std::optional<double>& ratio) {
  return ratio ? ordered_json(*ratio) : ordered_json();
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
    request.direct = root.boolean_or("direct", false);
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
      {"E_min", extreme_json(analysis.min, metres)},
      {"E_avg", estimate_json(analysis.average)},
      {"E_max", max_json(analysis.max, metres)},
      {"U0", ratio_json(analysis.min_to_average())},
      {"Ud", ratio_json(analysis.min_to_max())},
      {"levels", std::move(levels)},
      {"completeness", {{"certified", false}, {"undecided_cells", analysis.undecided}}},
      {"warnings", std::move(warnings)}});
}

}  // namespace caustic::service
