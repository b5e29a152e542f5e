#include "tests/stress/trial.h"

#include <algorithm>
#include <ctime>
#include <iterator>

#include "service/api/answer_json.h"

namespace caustic::stress {

double thread_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

Trial run_trial(const json& request) {
  const double begin = thread_seconds();
  service::ContourCall call = service::read_contour_call(request.dump());
  solver::ContourResult result = solver::trace_contours(call.system, call.request);
  const double cpu = thread_seconds() - begin;
  service::throw_if_unsupported(result);
  service::PolylineSet curves = service::to_polylines(call, result);
  return {request, std::move(call), std::move(result), std::move(curves), cpu};
}

bool is_warned(const solver::ContourResult& result) {
  // What says that nothing is wrong: no light, no levels, surfaces cut off far away.
  constexpr const char* kHarmless[] = {"clipped", "no_levels", "unlit_family", "sheets_instead"};
  const auto harmless = [&](const solver::Warning& w) {
    return std::find(std::begin(kHarmless), std::end(kHarmless), w.code) != std::end(kHarmless);
  };
  return !result.complete || !std::all_of(result.warnings.begin(), result.warnings.end(), harmless);
}

}  // namespace caustic::stress
