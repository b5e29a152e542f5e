// A job's report as a stream of events, whenever it changes.
#pragma once

#include <chrono>
#include <functional>
#include <optional>

#include "service/http/message.h"
#include "service/jobs/job_report.h"

namespace caustic::service {

/// Server-sent events: `job` with the report as data; the last one, when the job has ended, is
/// `end`. Between them a comment now and then, so that nobody takes the stream for dead.
class JobEvents : public EventSource {
 public:
  using Look = std::function<std::optional<JobReport>()>;
  explicit JobEvents(Look look) : look_(std::move(look)) {}

  bool next(std::string& out) override;

 private:
  Look look_;
  std::string last_;
  int id_ = 0;
  std::chrono::steady_clock::time_point last_sent_{};
};

/// `Last-Event-ID` of a client that has the end: it need not come again.
constexpr std::string_view kEndEventId = "end";

}  // namespace caustic::service
