// The calls that ask about points, from body to answer: paths between two of them, light at some.
// Nothing is stored. Knows neither HTTP nor the command line.
#pragma once

#include <atomic>
#include <string>
#include <string_view>

namespace caustic::service {

/// Both throw ProblemError for a bad request, and 503 when `stopping` becomes true.
std::string answer_paths(std::string_view body, const std::atomic<bool>* stopping = nullptr);
std::string answer_irradiance(std::string_view body, const std::atomic<bool>* stopping = nullptr);

}  // namespace caustic::service
