// The body of `POST /v1/contours`: what the engine is asked, and the identity of the answer.
#pragma once

#include <string>
#include <string_view>

#include "service/api/units.h"
#include "solver/contours.h"

namespace caustic::service {

constexpr double kMaxTimeMs = 60'000;
constexpr int kMaxVertices = 2'000'000;
constexpr int kMaxCells = 10'000'000;

struct ContourCall {
  solver::OpticalSystem system;
  solver::ContourRequest request;
  Units units;
  bool store = true;
  std::string scene_json;      ///< the canonical scene
  std::string request_sha256;  ///< of the canonical request
  std::string id;              ///< of a complete result
};

/// Throws ProblemError: 400 if the text is not JSON, 422 naming every fault of what it says.
ContourCall read_contour_call(std::string_view body);

}  // namespace caustic::service
