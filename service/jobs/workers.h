// The threads that compute, apart from those that talk to clients, and what waits for them.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace caustic::service {

class Workers {
 public:
  /// `most_waiting` tasks may wait beside those that run.
  Workers(int threads, std::size_t most_waiting);
  /// Tasks that have not begun are dropped, those that run are waited for.
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// First come, first served. False if the queue is full; then the task is not taken. `tag` is
  /// for withdraw().
  bool submit(std::function<void()> task, const void* tag = nullptr);
  /// What waits with this tag will not be done, and makes room.
  void withdraw(const void* tag);

  std::size_t waiting() const;
  bool full() const { return waiting() >= most_waiting_; }

 private:
  using Task = std::pair<const void*, std::function<void()>>;

  void work();

  const std::size_t most_waiting_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Task> tasks_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace caustic::service
