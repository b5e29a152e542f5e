// `POST /v1/paths`: the question and its answer, in the user's length unit.
#pragma once

#include <string>
#include <string_view>

#include "service/api/units.h"
#include "solver/paths_between.h"

namespace caustic::service {

struct PathCall {
  solver::OpticalSystem system;
  solver::PathsRequest request;
  Units units;
};

/// Throws ProblemError: 400 if the text is not JSON, 422 naming every fault of what it says.
PathCall read_path_call(std::string_view body);

std::string path_answer(const PathCall& call, const solver::PathsResult& result);

}  // namespace caustic::service
