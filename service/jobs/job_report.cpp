#include "service/jobs/job_report.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "service/api/json_text.h"

namespace caustic::service {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr std::array kStates = {"accepted", "running", "successful", "failed", "dismissed"};
constexpr std::string_view kResults = "/v1/results/";

Problem read_problem(const json& document) {
  Problem problem = make_problem(document.at("status"), document.at("detail"));
  for (const json& fault : document.at("errors"))
    problem.errors.push_back({fault.at("pointer"), fault.at("detail")});
  return problem;
}

}  // namespace

const char* to_string(JobState state) { return kStates[static_cast<std::size_t>(state)]; }

std::string to_json(const JobReport& report) {
  ordered_json out{{"id", report.id},
                   {"status", to_string(report.state)},
                   {"progress", report.progress},
                   {"result", nullptr},
                   {"problem", nullptr}};
  if (!report.result_id.empty()) out["result"] = std::string(kResults) + report.result_id;
  if (report.problem) out["problem"] = ordered_json::parse(to_json(*report.problem));
  return write_json(out);
}

std::optional<JobReport> read_job_report(std::string_view text) {
  try {
    const json document = json::parse(text);
    JobReport out;
    out.id = document.at("id");
    const auto state = std::find(kStates.begin(), kStates.end(), document.at("status"));
    if (state == kStates.end()) return std::nullopt;
    out.state = static_cast<JobState>(state - kStates.begin());
    out.progress = document.at("progress");
    if (const json& result = document.at("result"); result.is_string())
      out.result_id = result.get<std::string>().substr(kResults.size());
    if (const json& problem = document.at("problem"); problem.is_object())
      out.problem = read_problem(problem);
    return out;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

}  // namespace caustic::service
