// `POST /v1/analysis` and `isocaustic analysis`: what is asked about the light on the whole
// receiver, and the answer.
#pragma once

#include <string>
#include <string_view>

#include "service/api/units.h"
#include "solver/analysis.h"

namespace caustic::service {

struct AnalysisCall {
  solver::OpticalSystem system;
  solver::ContourRequest request;
  Units units;
};

/// Throws ProblemError: 400 if the text is not JSON, 422 naming every fault of what it says.
AnalysisCall read_analysis_call(std::string_view body);

/// Throws ProblemError (422) where this version lacks what was asked.
std::string analysis_answer(const AnalysisCall& call, const solver::Analysis& analysis);

}  // namespace caustic::service
