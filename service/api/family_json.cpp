#include "service/api/family_json.h"

#include <map>
#include <nlohmann/json.hpp>

namespace caustic::service {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxFamilies = 10'000;

/// Surface indices of one family.
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
    const solver::SystemSurface& surface = scene.surfaces[found->second];
    if (!surface.optics.passes_light_on())
      faults.add(name.pointer, "absorbs all light, so no family goes on from it");
    if (!family.empty() && family.back() == found->second && surface.shape && surface.shape->flat())
      faults.add(name.pointer, "never occurs: light that leaves a plane does not meet it again");
    family.push_back(found->second);
  }
  if (place.value->is_array() && place.value->empty())
    faults.add(place.pointer, "needs at least one surface");
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

FamilyRequest read_families(ObjectReader& root, const Scene& scene) {
  FamilyRequest out;
  const JsonPlace place = root.member_or("families", json::object());
  if (place.value->is_array()) {
    read_family_list(place, scene, out.listed, root.faults());
    return out;
  }
  if (!place.value->is_object()) {
    root.faults().add(place.pointer, "must be an array of families or an object");
    return out;
  }
  ObjectReader families(place, root.faults());
  const JsonPlace bounces = families.member_or("max_bounces", 1.0);
  out.max_bounces = read_integer(bounces, 1, kMaxBounces, root.faults());
  out.min_flux_share = families.number_or("min_flux_share", {0.0, 1.0}, 1e-6);
  return out;
}

}  // namespace caustic::service
