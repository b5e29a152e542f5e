#include "service/api/family_json.h"

#include <map>
#include <nlohmann/json.hpp>

namespace caustic::service {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxFamilies = 10'000;

/// Surface indices of one family: exactly one mirror in this version.
std::vector<int> read_family(const JsonPlace& place, const Scene& scene,
                             const std::map<std::string, int>& index, Faults& faults) {
  std::vector<int> family;
  const auto names = read_elements(place, kMaxBounces, faults);
  for (const JsonPlace& name : names) {
    const auto found = index.find(read_string(name, faults));
    if (!name.value->is_string()) continue;
    if (found == index.end()) {
      faults.add(name.pointer, "no surface has this name");
      continue;
    }
    family.push_back(found->second);
    if (scene.surfaces[found->second].optics.kind != solver::Optics::Kind::mirror)
      faults.add(name.pointer, "not a mirror");
  }
  if (place.value->is_array() && place.value->empty())
    faults.add(place.pointer, "needs at least one surface");
  if (names.size() > 1) faults.not_supported(place.pointer, "a family of more than one bounce");
  return family;
}

void read_family_list(const JsonPlace& place, const Scene& scene, Families& families,
                      Faults& faults) {
  std::map<std::string, int> index;
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
    index.emplace(scene.surfaces[i].name, static_cast<int>(i));
  std::map<std::vector<int>, int> seen;
  for (const JsonPlace& element : read_elements(place, kMaxFamilies, faults)) {
    families.push_back(read_family(element, scene, index, faults));
    if (!families.back().empty() && ++seen[families.back()] == 2)
      faults.add(element.pointer, "given twice");
  }
  if (place.value->is_array() && place.value->empty())
    faults.add(place.pointer, "needs at least one family");
}

}  // namespace

Families read_families(ObjectReader& root, const Scene& scene) {
  Families out;
  const JsonPlace place = root.member_or("families", json::object());
  if (place.value->is_array()) {
    read_family_list(place, scene, out, root.faults());
    return out;
  }
  if (!place.value->is_object()) {
    root.faults().add(place.pointer, "must be an array of families or an object");
    return out;
  }
  ObjectReader families(place, root.faults());
  const JsonPlace bounces = families.member_or("max_bounces", 1.0);
  if (read_integer(bounces, 1, kMaxBounces, root.faults()) > 1)
    root.faults().not_supported(bounces.pointer, "more than one bounce");
  families.number_or("min_flux_share", {0.0, 1.0}, 1e-6);
  return out;
}

}  // namespace caustic::service
