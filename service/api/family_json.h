// `families` of a request: which lists of surfaces light may go by.
#pragma once

#include <vector>

#include "service/api/json_reader.h"
#include "service/api/scene_json.h"

namespace caustic::service {

constexpr int kMaxBounces = 8;

/// Surface indices in the order of the light.
using Families = std::vector<std::vector<int>>;

/// Empty stands for every mirror by itself.
Families read_families(ObjectReader& root, const Scene& scene);

}  // namespace caustic::service
