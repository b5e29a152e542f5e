// How much work a request may do, and how much it has done.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace caustic::solver {

/// So many cells or vertices are worked off before the clock is read again, which takes as long as
/// a fifth of an evaluation.
constexpr std::size_t kBetweenChecks = 16;

/// Shared by all threads of one request.
class Budget {
 public:
  Budget(double seconds, std::size_t vertices, const std::atomic<bool>* cancelled)
      : deadline_(std::chrono::steady_clock::now() +
                  std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                      std::chrono::duration<double>(seconds))),
        vertices_left_(static_cast<std::int64_t>(vertices)),
        cancelled_(cancelled) {}

  /// True once the time is up, the vertices are spent or the request was cancelled; stays true.
  bool exhausted() { return vertices_left_.load(std::memory_order_relaxed) < 0 || out_of_time(); }
  /// The same but for the vertices: what has been traced may still be finished.
  bool out_of_time() {
    if (out_of_time_.load(std::memory_order_relaxed)) return true;
    if (cancelled() || std::chrono::steady_clock::now() > deadline_) {
      out_of_time_.store(true, std::memory_order_relaxed);
    }
    return out_of_time_.load(std::memory_order_relaxed);
  }
  /// Nobody wants the result: not even what is missing in it has to be said.
  bool cancelled() const { return cancelled_ && cancelled_->load(std::memory_order_relaxed); }
  void spend_vertices(std::size_t n) { vertices_left_ -= static_cast<std::int64_t>(n); }
  void count_evaluations(std::uint64_t n) { evaluations_ += n; }
  std::uint64_t evaluations() const { return evaluations_; }

 private:
  std::chrono::steady_clock::time_point deadline_;
  std::atomic<std::int64_t> vertices_left_;
  std::atomic<std::uint64_t> evaluations_{0};
  std::atomic<bool> out_of_time_{false};
  const std::atomic<bool>* cancelled_;
};

}  // namespace caustic::solver
