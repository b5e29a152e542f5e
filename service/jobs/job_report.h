// What is known of a job: as JSON for clients, and as it lies on disk.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "service/api/problem.h"

namespace caustic::service {

enum class JobState : std::uint8_t { accepted, running, successful, failed, dismissed };

struct JobReport {
  std::string id;
  JobState state = JobState::accepted;
  double progress = 0.0;  ///< 0…1
  std::string result_id;  ///< of a successful one; else empty
  std::optional<Problem> problem;
  /// Time in the queue, s, as the server that runs it knows it; not part of the JSON.
  std::optional<double> waited;

  bool ended() const { return state >= JobState::successful; }
};

const char* to_string(JobState state);

/// The answer to `GET /v1/jobs/{id}`.
std::string to_json(const JobReport& report);

/// Nothing if the text is no report.
std::optional<JobReport> read_job_report(std::string_view json);

}  // namespace caustic::service
