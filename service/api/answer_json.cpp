#include "service/api/answer_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "service/api/identity.h"
#include "service/api/json_reader.h"
#include "service/api/json_text.h"
#include "service/formats/format.h"

namespace caustic::service {
namespace {

using nlohmann::ordered_json;
using solver::ContourResult;
using solver::Curve;
using solver::CurveVertex;

/// So many undecided cells are listed; all are counted.
constexpr std::size_t kListedCells = 1000;

bool is_finite(const Curve& curve) {
  bool finite = std::isfinite(curve.level) && std::isfinite(curve.length) &&
                std::isfinite(curve.max_residual);
  for (const CurveVertex& v : curve.vertices)
    finite = finite && v.uv.allFinite() && v.p.allFinite() && v.x.allFinite() &&
             v.gradient.allFinite() &&
             std::isfinite(v.irradiance + v.residual + v.arc_length + v.dark + v.bright);
  return finite;
}

void drop_curves_that_are_not_finite(ContourResult& result) {
  const auto dropped = std::erase_if(result.curves, [](const Curve& c) { return !is_finite(c); });
  if (!dropped) return;
  result.certified = false;
  result.warnings.push_back({"not_finite", std::to_string(dropped) +
                                               " curves had a number that is not finite and were "
                                               "left out"});
}

PolylineVertex to_vertex(const CurveVertex& v, double metres) {
  const double scale = 1.0 / metres;
  PolylineVertex out;
  for (int i = 0; i < 3; ++i) {
    out.position[i] = v.p[i] * scale;
    out.gradient[i] = v.gradient[i] * metres;
    out.reflector_point[i] = v.x[i] * scale;
  }
  out.uv = {v.uv.x() * scale, v.uv.y() * scale};
  out.irradiance = v.irradiance;
  out.residual = v.residual;
  out.arc_length = v.arc_length * scale;
  out.dark = v.dark;
  out.bright = v.bright;
  return out;
}

std::string units_json(const Units& units) {
  const std::string irradiance = units.irradiance(), length = units.length.name;
  return write_json(ordered_json{{"length", length},
                                 {"quantity", units.quantity()},
                                 {"irradiance", irradiance},
                                 {"gradient", irradiance + "/" + length}});
}

ordered_json families_json(const ContourCall& call, const ContourResult& result) {
  auto out = ordered_json::array();
  for (const solver::FamilyReport& family : result.families) {
    auto names = ordered_json::array();
    for (int surface : family.surfaces) names.push_back(call.system.surfaces()[surface].name);
    out.push_back({{"id", family.id}, {"surfaces", names}, {"flux", nullptr}});
    if (std::isfinite(family.flux)) out.back()["flux"] = family.flux;
  }
  return out;
}

ordered_json curve_json(const Curve& curve, std::size_t id, double metres, bool total) {
  const bool level =
      curve.kind != solver::CurveKind::caustic && curve.kind != solver::CurveKind::boundary;
  auto ends = ordered_json::array();
  for (solver::Ending end : curve.ends) ends.push_back(solver::to_string(end));
  ordered_json out{{"curve_id", id},
                   {"kind", solver::to_string(curve.kind)},
                   {"level", level ? ordered_json(curve.level) : ordered_json()},
                   {"measure", total ? "total" : "sheet"},
                   {"family_id", curve.family_id},
                   {"parity", curve.parity},
                   {"closed", curve.closed},
                   {"ends", ends},
                   {"vertices", curve.vertices.size()},
                   {"length", curve.length / metres},
                   {"max_residual", curve.max_residual}};
  if (total) {
    out["boundary"] = static_cast<int>(curve.boundary);
    out["ring_id"] = curve.ring_id;
    out["ring_order"] = curve.ring_order;
  }
  return out;
}

ordered_json critical_points_json(const ContourResult& result, double metres) {
  auto out = ordered_json::array();
  for (const solver::CriticalPlace& c : result.critical_points) {
    out.push_back({{"uv", {c.uv.x() / metres, c.uv.y() / metres}},
                   {"x", {c.x.x() / metres, c.x.y() / metres, c.x.z() / metres}},
                   {"E", c.E},
                   {"type", solver::to_string(c.type)},
                   {"family_id", c.family_id}});
  }
  return out;
}

ordered_json regions_json(const ContourResult& result, double metres) {
  auto out = ordered_json::array();
  for (const solver::Region& region : result.regions) {
    out.push_back({{"uv_inside", {region.uv_inside.x() / metres, region.uv_inside.y() / metres}},
                   {"branches", region.branches}});
  }
  return out;
}

ordered_json completeness_json(const ContourResult& result, double metres) {
  ordered_json out{{"certified", result.certified}, {"undecided_cells", result.undecided_cells}};
  if (!result.unproven.empty()) out["unproven"] = result.unproven;
  auto cells = ordered_json::array();
  for (const solver::Undecided& cell : result.undecided) {
    if (cells.size() == kListedCells) break;
    auto levels = ordered_json::array(), corners = ordered_json::array();
    for (const double level : cell.levels)
      levels.push_back(level < 0.0 ? ordered_json() : ordered_json(level));
    for (const geometry::Point& x : cell.corners)
      corners.push_back({x.x() / metres, x.y() / metres, x.z() / metres});
    cells.push_back({{"family_id", cell.family_id},
                     {"levels", std::move(levels)},
                     {"corners", std::move(corners)}});
  }
  if (!cells.empty()) out["undecided"] = std::move(cells);
  return out;
}

ordered_json files_json(const std::string& id, bool stored) {
  auto out = ordered_json::object();
  if (stored)
    for (const Format& format : formats())
      out[format.suffix] = "/v1/results/" + id + "." + format.suffix;
  return out;
}

}  // namespace

void throw_if_unsupported(const ContourResult& result) {
  if (!result.unsupported) return;
  Faults faults;
  faults.not_supported("/measure", *result.unsupported);
  faults.throw_if_any();
}

PolylineSet to_polylines(const ContourCall& call, ContourResult& result) {
  drop_curves_that_are_not_finite(result);
  const double metres = call.units.length.metres;
  const geometry::Vec2 size = 2.0 / metres * call.system.receiver().half;
  PolylineSet out;
  out.receiver_size = {size.x(), size.y()};
  out.total = result.measure == solver::Measure::total;
  out.length_unit = call.units.length.name;
  out.irradiance_unit = call.units.irradiance();
  out.quantity = call.units.irradiance_name();
  out.scene_json = call.scene_json;
  out.units_json = units_json(call.units);
  out.engine_version = kEngineVersion;
  out.request_sha256 = call.request_sha256;
  for (const Curve& curve : result.curves) {
    out.curves.push_back({static_cast<PolylineKind>(curve.kind), curve.closed, curve.family_id,
                          curve.parity, static_cast<std::int32_t>(curve.boundary), curve.ring_id,
                          curve.ring_order, 0, curve.level, curve.length / metres,
                          out.vertices.size(), curve.vertices.size()});
    for (const CurveVertex& v : curve.vertices) out.vertices.push_back(to_vertex(v, metres));
  }
  return out;
}

std::string answer_json(const ContourCall& call, const ContourResult& result, const std::string& id,
                        bool stored, const std::string& geojson) {
  const double metres = call.units.length.metres;
  const bool total = result.measure == solver::Measure::total;
  auto curves = ordered_json::array();
  for (std::size_t i = 0; i < result.curves.size(); ++i)
    curves.push_back(curve_json(result.curves[i], i, metres, total));
  auto skipped = ordered_json::array(), warnings = ordered_json::array();
  for (const auto& [stage, reason] : result.skipped)
    skipped.push_back({{"stage", stage}, {"reason", reason}});
  for (const auto& [code, detail] : result.warnings)
    warnings.push_back({{"code", code}, {"detail", detail}});
  ordered_json answer{{"id", id},
                      {"engine_version", kEngineVersion},
                      {"complete", result.complete},
                      {"families", families_json(call, result)},
                      {"curves", std::move(curves)},
                      {"completeness", completeness_json(result, metres)},
                      {"skipped", std::move(skipped)},
                      {"work", {{"evaluations", result.evaluations}, {"seconds", result.seconds}}},
                      {"warnings", std::move(warnings)},
                      {"files", files_json(id, stored)}};
  if (call.request.critical_points)
    answer["critical_points"] = critical_points_json(result, metres);
  if (call.request.regions && total) answer["regions"] = regions_json(result, metres);
  std::string out = write_json(answer);
  if (!geojson.empty()) {
    out.back() = ',';
    out += "\"geojson\":" + geojson + "}";
  }
  return out;
}

}  // namespace caustic::service
