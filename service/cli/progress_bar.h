// A bar on stderr for work that takes longer than a second, if somebody looks at a terminal.
#pragma once

#include <chrono>
#include <functional>

namespace caustic::service {

class ProgressBar {
 public:
  ProgressBar();
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Called with the share done. Empty if stderr is no terminal.
  std::function<void(double)> callback();

 private:
  void show(double share);

  std::chrono::steady_clock::time_point start_;
  int shown_percent_ = -1;
};

}  // namespace caustic::service
