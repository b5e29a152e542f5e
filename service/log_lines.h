// Lines for a log that may be slow or stuck: a pipe that nobody reads must not stop the service.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "service/descriptor.h"

namespace caustic::service {

class LogLines {
 public:
  /// Takes the descriptor.
  explicit LogLines(Descriptor file);
  /// Writes what is left, as far as the file takes it at once.
  ~LogLines();

  /// Never waits. Lines beyond what is held for a slow reader are lost, and counted in a line of
  /// their own.
  void write(std::string line);

 private:
  void work();
  bool write_now(const std::string& text) const;

  const Descriptor file_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string pending_;
  std::size_t lost_ = 0;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace caustic::service
