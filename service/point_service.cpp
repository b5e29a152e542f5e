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

[[noreturn]] void throw_too_long(const char* fewer) {
  throw ProblemError(
      make_problem(503, std::string("more than a minute of work: ask for ") + fewer));
}

/// What the solver finds within the time that a call has; all of it, or a problem.
template <typename Solve, typename System, typename Request>
auto in_time(Solve solve, const System& system, Request& request,
             const std::atomic<bool>* cancelled, const char* fewer) {
  request.time_limit = std::chrono::duration<double>(kLongest).count();
  request.cancelled = cancelled;
  auto result = solve(system, request);
  throw_if_cancelled(cancelled);
  if (!result.complete) throw_too_long(fewer);
  return result;
}

}  // namespace

std::string answer_paths(std::string_view body, const std::atomic<bool>* cancelled) {
  PathCall call = read_path_call(body);
  return path_answer(
      call, in_time(solver::paths_between, call.system, call.request, cancelled, "fewer families"));
}

std::string answer_irradiance(std::string_view body, const std::atomic<bool>* cancelled) {
  const IrradianceCall call = read_irradiance_call(body);
  const auto deadline = std::chrono::steady_clock::now() + kLongest;
  solver::LightMeter meter(call.system, call.families, call.direct);
  std::vector<solver::PointIrradiance> readings;
  readings.reserve(call.points.size());
  for (const geometry::Vec2& q : call.points) {
    throw_if_cancelled(cancelled);
    if (std::chrono::steady_clock::now() > deadline) throw_too_long("fewer points");
    readings.push_back(meter.at(q));
  }
  return irradiance_answer(call, readings);
}

std::string answer_analysis(std::string_view body, const std::atomic<bool>* cancelled) {
  AnalysisCall call = read_analysis_call(body);
  call.request.vertex_limit = kMostVertices;
  return analysis_answer(
      call, in_time(solver::analyse, call.system, call.request, cancelled, "fewer levels"));
}

}  // namespace caustic::service
