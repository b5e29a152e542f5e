// Counts of what the service does, for operators.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "solver/contours.h"

namespace caustic::service {

class Metrics {
 public:
  /// Of one answer; `route` is the pattern, so that there are few of them.
  void count_request(const std::string& route, int status, double seconds);
  void count_result(const solver::ContourResult& result);
  void count_cache_hit() { ++cache_hits_; }
  void count_cache_miss() { ++cache_misses_; }

  struct Gauge {
    const char* name;
    const char* help;
    double value;
  };
  /// Prometheus' text format 0.0.4.
  std::string text(const std::vector<Gauge>& gauges) const;

  static constexpr std::array kBounds = {0.001, 0.005, 0.025, 0.1, 0.5, 2.5, 10.0, 60.0};  // s

 private:
  mutable std::mutex mutex_;
  std::map<std::pair<std::string, int>, std::uint64_t> requests_;
  std::array<std::uint64_t, kBounds.size() + 1> histogram_{};  ///< not yet summed up
  double seconds_ = 0.0;
  std::map<std::string, std::uint64_t> curves_;  ///< by ending
  std::atomic<std::uint64_t> evaluations_ = 0, cache_hits_ = 0, cache_misses_ = 0;
};

}  // namespace caustic::service
