// One POST from body to answer: read, look up, trace, store. Knows neither HTTP nor the command
// line.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <string_view>

#include "service/api/contour_json.h"
#include "service/results/result_record.h"
#include "service/results/result_store.h"
#include "service/shared_work.h"
#include "solver/contours.h"

namespace caustic::service {

using Engine = std::function<solver::ContourResult(const solver::OpticalSystem&,
                                                   const solver::ContourRequest&)>;

class ContourService {
 public:
  /// When `stopping` becomes true, running work ends with 503.
  ContourService(Engine engine, const ResultStore& store,
                 const std::atomic<bool>* stopping = nullptr)
      : engine_(std::move(engine)), store_(store), stopping_(stopping) {}

  /// The answer. Throws ProblemError for a bad request. The same request from several threads at a
  /// time is traced once.
  std::string post(std::string_view body) const;

 private:
  std::string compute(ContourCall& call) const;

  Engine engine_;
  const ResultStore& store_;
  const std::atomic<bool>* stopping_;
  mutable SharedWork under_way_;
};

/// Identity of what the engine found: the request's own if it is whole, else a random one.
std::string result_id(const ContourCall& call, const solver::ContourResult& result);

}  // namespace caustic::service
