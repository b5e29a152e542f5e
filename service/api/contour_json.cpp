#include "service/api/contour_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "service/api/family_json.h"
#include "service/api/identity.h"
#include "service/api/json_text.h"
#include "service/api/level_json.h"
#include "service/api/scene_json.h"

namespace caustic::service {
namespace {

using nlohmann::json;
using solver::ContourRequest;

constexpr double kDefaultTimeMs = 5000;
constexpr int kDefaultVertices = 500'000;
constexpr int kDefaultCells = 200'000;

/// What an answer may include, in the order of the canonical request.
struct Included {
  const char* name;
  bool ContourRequest::*wanted;
  bool of_total;  ///< it belongs to the total only
};
constexpr Included kIncluded[] = {{"boundaries", &ContourRequest::boundaries, true},
                                  {"caustic", &ContourRequest::caustic, false},
                                  {"critical_points", &ContourRequest::critical_points, false},
                                  {"isolux", &ContourRequest::isolux, false},
                                  {"regions", &ContourRequest::regions, true}};

void read_included(const JsonPlace& word, ContourRequest& request, Faults& faults) {
  const std::string name = read_string(word, faults);
  std::string names;
  for (const Included& included : kIncluded) {
    names += (names.empty() ? "" : ", ") + std::string(included.name);
    if (name != included.name) continue;
    if (included.of_total && request.measure != solver::Measure::total)
      return faults.add(word.pointer, "belongs to the total: see measure");
    request.*included.wanted = true;
    return;
  }
  if (word.value->is_string()) faults.add(word.pointer, "must be one of: " + names);
}

void read_include(ObjectReader& root, ContourRequest& request) {
  const JsonPlace place = root.member_or("include", {"caustic", "isolux"});
  for (const Included& included : kIncluded) request.*included.wanted = false;
  for (const JsonPlace& word : read_elements(place, 100, root.faults()))
    read_included(word, request, root.faults());
  if (!place.value->is_array()) return;
  if (place.value->empty()) root.faults().add(place.pointer, "needs at least one of its words");
  *place.value = json::array();  // a set: neither order nor repetition is part of the question
  for (const Included& included : kIncluded) {
    if (request.*included.wanted) place.value->push_back(included.name);
  }
}

void read_tolerance(ObjectReader& root, const Scene& scene, ContourRequest& request) {
  const double metres = scene.units.length.metres;
  const double side = scene.receiver.width() / metres;
  const bool sound_side = std::isfinite(side) && side > 0.0;
  ObjectReader tolerance(root.member_or("tolerance", json::object()), root.faults());
  request.irradiance_tolerance = tolerance.number_or("irradiance", {1e-15, 0.1}, 1e-9);
  const Range chords = sound_side ? Range{1e-9 * side, side} : kPositive;
  request.chord_tolerance =
      metres * tolerance.number_or("chord", chords, sound_side ? 1e-4 * side : 1.0);
}

void read_limits(ObjectReader& root, ContourRequest& request) {
  ObjectReader limits(root.member_or("limits", json::object()), root.faults());
  request.time_limit = 1e-3 * limits.number_or("time_ms", {0.0, kMaxTimeMs, true}, kDefaultTimeMs);
  request.vertex_limit = static_cast<std::size_t>(
      read_integer(limits.member_or("vertices", kDefaultVertices), 1, kMaxVertices, root.faults()));
  request.cell_limit = static_cast<std::size_t>(
      read_integer(limits.member_or("cells", kDefaultCells), 1, kMaxCells, root.faults()));
}

// By default the total, or sheets where that cannot be traced. The direct light is part of the
// total only, so who asks for it means that.
void read_measure(ObjectReader& root, ContourRequest& request) {
  const bool named = root.optional_member("measure").has_value();
  request.direct = root.boolean_or("direct", false);
  request.sheets_instead = !named && !request.direct;
  const bool sheet = named && root.word("measure", {"total", "sheet"}) == "sheet";
  request.measure = sheet ? solver::Measure::sheet : solver::Measure::total;
  if (sheet && request.direct)
    root.faults().add(root.pointer_to("direct"), "belongs to the total: see measure");
}

Scene read_members(ObjectReader& root, ContourRequest& request, bool& store) {
  Scene scene;
  if (const auto place = root.member("scene")) scene = read_scene(*place, root.faults());
  const FamilyRequest families = read_families(root, scene);
  request.families = families.listed;
  request.max_bounces = families.max_bounces;
  request.min_flux_share = families.min_flux_share;
  request.levels = read_levels(root);
  request.certify = root.boolean_or("certify", false);
  read_measure(root, request);
  read_include(root, request);
  read_tolerance(root, scene, request);
  read_limits(root, request);
  store = root.boolean_or("store", true);
  return scene;
}

}  // namespace

ContourCall read_contour_call(std::string_view body) {
  json document = parse_json(body);
  Faults faults;
  Scene scene;
  ContourRequest request;
  bool store = true;
  {
    ObjectReader root({&document, ""}, faults);
    scene = read_members(root, request, store);
  }
  faults.throw_if_any();
  document.erase("limits");
  document.erase("store");
  const std::string canonical = write_json(document);
  return {solver::OpticalSystem::build(scene.light, std::move(scene.surfaces), scene.receiver),
          std::move(request),
          scene.units,
          store,
          write_json(document["scene"]),
          sha256_hex(canonical),
          sha256_hex(canonical + "\n" + kEngineVersion)};
}

}  // namespace caustic::service
