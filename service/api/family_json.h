// `families` of a request: which lists of surfaces light may go by.
#pragma once

#include <vector>

#include "service/api/json_reader.h"
#include "service/api/scene_json.h"

namespace caustic::service {

constexpr int kMaxBounces = 8;

/// Surface indices in the order of the light.
using Families = std::vector<std::vector<int>>;

/// Families by name, or else all that occur with so many bounces.
struct FamilyRequest {
  Families listed;
  int max_bounces = 1;
  double min_flux_share = 1e-6;
};
FamilyRequest read_families(ObjectReader& root, const Scene& scene);

}  // namespace caustic::service
