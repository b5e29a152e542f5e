// One request, read and answered as the service does it, with what it took.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "service/api/contour_json.h"
#include "service/formats/polyline_set.h"

namespace caustic::stress {

using nlohmann::json;

struct Trial {
  json request;
  service::ContourCall call;
  solver::ContourResult result;
  service::PolylineSet curves;  ///< as files have them
  double cpu;                   ///< s, of this thread, reading and tracing

  const geometry::ReceiverFrame& receiver() const { return call.system.receiver(); }
  bool total() const { return result.measure == solver::Measure::total; }
  /// Distance that the polylines may be off, m.
  double chord() const {
    const double asked = call.request.chord_tolerance;
    return asked > 0.0 ? asked : 1e-4 * receiver().width();
  }
};

/// Throws service::ProblemError for what is refused.
Trial run_trial(const json& request);

/// True if the answer says that its curves may lack something or be less exact than asked.
bool is_warned(const solver::ContourResult& result);

/// CPU time of this thread, s.
double thread_seconds();

}  // namespace caustic::stress
