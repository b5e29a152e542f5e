// The calls that are answered by numbers, from body to answer: paths between two points, light at
// some, light on all of the receiver. Nothing is stored. Knows neither HTTP nor the command line.
#pragma once

#include <atomic>
#include <string>
#include <string_view>

namespace caustic::service {

/// All throw ProblemError for a bad request, and 503 when `cancelled` becomes true.
std::string answer_paths(std::string_view body, const std::atomic<bool>* cancelled = nullptr);
std::string answer_irradiance(std::string_view body, const std::atomic<bool>* cancelled = nullptr);
std::string answer_analysis(std::string_view body, const std::atomic<bool>* cancelled = nullptr);

}  // namespace caustic::service
