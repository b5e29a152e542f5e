#include "service/point_service.h"

#include <chrono>

#include "service/api/analysis_json.h"
#include "service/api/irradiance_json.h"
#include "service/api/path_json.h"
#include "service/api/problem.h"

namespace caustic::service {
namespace {

// A call is one answer; what takes longer has to be asked in parts.
constexpr auto kLongest = std::chrono::seconds(60);
constexpr std::size_t kMostVertices = 10'000'000;

void throw_if_cancelled(const std::atomic<bool>* cancelled) {
  if (cancelled && *cancelled)
    throw ProblemError(make_problem(503, "the computation was cancelled"));
}

}  // namespace

std::string answer_paths(std::string_view body, const std::atomic<bool>* cancelled) {
  PathCall call = read_path_call(body);
  call.request.time_limit = std::chrono::duration<double>(kLongest).count();
  call.request.cancelled = cancelled;
  const solver::PathsResult result = solver::paths_between(call.system, call.request);
  throw_if_cancelled(cancelled);
  if (!result.complete)
    throw ProblemError(make_problem(503, "more than a minute of work: ask for fewer families"));
  return path_answer(call, result);
}

std::string answer_irradiance(std::string_view body, const std::atomic<bool>* cancelled) {
  const IrradianceCall call = read_irradiance_call(body);
  const auto deadline = std::chrono::steady_clock::now() + kLongest;
  solver::LightMeter meter(call.system, call.families, call.direct);
  std::vector<solver::PointIrradiance> readings;
  readings.reserve(call.points.size());
  for (const geometry::Vec2& q : call.points) {
    throw_if_cancelled(cancelled);
    if (std::chrono::steady_clock::now() > deadline)
      throw ProblemError(make_problem(503, "more than a minute of work: ask for fewer points"));
    readings.push_back(meter.at(q));
  }
  return irradiance_answer(call, readings);
}

std::string answer_analysis(std::string_view body, const std::atomic<bool>* cancelled) {
  AnalysisCall call = read_analysis_call(body);
  call.request.time_limit = std::chrono::duration<double>(kLongest).count();
  call.request.vertex_limit = kMostVertices;
  call.request.cancelled = cancelled;
  const solver::Analysis analysis = solver::analyse(call.system, call.request);
  throw_if_cancelled(cancelled);
  if (!analysis.complete)
    throw ProblemError(make_problem(503, "more than a minute of work: ask for fewer levels"));
  return analysis_answer(call, analysis);
}

}  // namespace caustic::service
