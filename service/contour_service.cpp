#include "service/contour_service.h"

#include "service/api/answer_json.h"
#include "service/api/identity.h"
#include "service/api/problem.h"
#include "service/formats/format.h"

namespace caustic::service {

std::string result_id(const ContourCall& call, const solver::ContourResult& result) {
  return result.complete ? call.id : random_id();
}

std::string ContourService::post(std::string_view body) const {
  ContourCall call = read_contour_call(body);
  if (!call.store) return compute(call);
  return under_way_.once(call.id, [&] {
    const auto answer = store_.load_answer(call.id);
    return answer ? *answer : compute(call);
  });
}

std::string ContourService::compute(ContourCall& call) const {
  call.request.cancelled = stopping_;
  solver::ContourResult result = engine_(call.system, call.request);
  if (stopping_ && *stopping_) throw ProblemError(make_problem(503, "the service is stopping"));
  throw_if_unsupported(result);
  const std::string id = result_id(call, result);
  ResultRecord record;
  record.curves = to_polylines(call, result);
  if (!call.store) return answer_json(call, result, id, false, write_geojson(record.curves));
  record.answer = answer_json(call, result, id, true);
  if (store_.save(id, record)) return record.answer;
  // Another server on the same folder was first: its answer is the one that stays.
  return store_.load_answer(id).value_or(record.answer);
}

}  // namespace caustic::service
