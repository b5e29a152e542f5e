// Times of one run of a benchmark. On a machine that others use the minimum is the one that
// repeats.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <vector>

namespace caustic::bench {

class Samples {
 public:
  /// Runs and times it, s.
  template <class Action>
  void time(const Action& action) {
    const auto begin = std::chrono::steady_clock::now();
    action();
    add(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  void add(double seconds) { seconds_.push_back(seconds); }

  double min() const { return *std::min_element(seconds_.begin(), seconds_.end()); }
  double median() const {
    std::vector<double> sorted = seconds_;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    return *middle;
  }
  void report_milliseconds(benchmark::State& state) const {
    state.counters["min_ms"] = 1e3 * min();
    state.counters["median_ms"] = 1e3 * median();
  }

 private:
  std::vector<double> seconds_;
};

}  // namespace caustic::bench
