#include "service/contour_service.h"

#include "service/api/answer_json.h"
#include "service/api/identity.h"
#include "service/api/problem.h"
#include "service/formats/format.h"

namespace caustic::service {
std::string result_id(const ContourCall& call, const solver::ContourResult& result) {
  return result.complete ? call.id : random_id();
}

std::string ContourService::key_of(const ContourCall& call) {
  if (!call.store) return {};
  const auto& request = call.request;
  return call.id + ' ' + std::to_string(request.time_limit) + ' ' +
         std::to_string(request.vertex_limit) + ' ' + std::to_string(request.cell_limit);
}

std::shared_ptr<const std::string> ContourService::find(const ContourCall& call) const {
  auto answer = call.store ? store_.find_answer(call.id) : nullptr;
  if (metrics_ && call.store) answer ? metrics_->count_cache_hit() : metrics_->count_cache_miss();
  return answer;
}

JobResult ContourService::compute(ContourCall& call, JobControl& control) const {
  call.request.cancelled = control.cancelled();
  // The share is of the curves of sheets; what is made of them takes about as long.
  call.request.progress = [&control](double share) { control.report(0.5 * share); };
  control.expect(call.request.time_limit);
  solver::ContourResult result = engine_(call.system, call.request);
  control.throw_if_cancelled();
  throw_if_unsupported(result);
  if (metrics_) metrics_->count_result(result);
  const std::string id = result_id(call, result);
  ResultRecord record;
  record.curves = to_polylines(call, result);
  control.throw_if_cancelled();  // each of these steps may take a while
  if (!call.store) return {answer_json(call, result, id, false, write_geojson(record.curves))};
  record.answer = answer_json(call, result, id, true);
  control.throw_if_cancelled();
  if (store_.save(id, record)) return {record.answer, id};
  // Another server on the same folder was first: its answer is the one that stays.
  return {store_.load_answer(id).value_or(record.answer), id};
}

std::string ContourService::post(std::string_view body) const {
  ContourCall call = read_contour_call(body);
  if (const auto answer = find(call)) return *answer;
  JobControl control;
  return compute(call, control).answer;
}

}  // namespace caustic::service
