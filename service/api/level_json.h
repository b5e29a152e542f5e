// `levels` of a request: the given ones, or a rule that chooses them.
#pragma once

#include "service/api/json_reader.h"
#include "solver/contours.h"

namespace caustic::service {

constexpr std::size_t kMaxLevels = 1000;

/// Numbers in the order given; the solver sorts them.
solver::LevelRequest read_levels(ObjectReader& root);

}  // namespace caustic::service
