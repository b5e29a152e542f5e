// POST /v1/contours without HTTP: read, look up, trace, store.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "service/api/contour_json.h"
#include "service/jobs/job.h"
#include "service/metrics.h"
#include "service/results/result_record.h"
#include "service/results/result_store.h"
#include "solver/contours.h"

namespace caustic::service {

using Engine = std::function<solver::ContourResult(const solver::OpticalSystem&,
                                                   const solver::ContourRequest&)>;

class ContourService {
 public:
  ContourService(Engine engine, const ResultStore& store, Metrics* metrics = nullptr)
      : engine_(std::move(engine)), store_(store), metrics_(metrics) {}

  /// The answer that is stored for this call, or null.
  std::shared_ptr<const std::string> find(const ContourCall& call) const;
  /// Traces and stores. Throws ProblemError for what the engine lacks, a full disk, or if it was
  /// cancelled.
  JobResult compute(ContourCall& call, JobControl& control) const;
  /// All of it at once: the answer to this body.
  std::string post(std::string_view body) const;

  /// Of requests that may share one computation: same scene, same limits. Empty: none may.
  static std::string key_of(const ContourCall& call);

 private:
  Engine engine_;
  const ResultStore& store_;
  Metrics* metrics_;
};

/// Identity of what the engine found: the request's own if it is whole, else a random one.
std::string result_id(const ContourCall& call, const solver::ContourResult& result);

}  // namespace caustic::service
