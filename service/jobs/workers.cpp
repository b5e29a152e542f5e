#include "service/jobs/workers.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <iterator>

namespace caustic::service {
namespace {

/// Who talks to clients goes first: an answer about health takes microseconds, a computation
/// seconds. (Linux: the priority of a thread is its own.)
constexpr int kNiceness = 5;

}  // namespace

Workers::Workers(int threads, std::size_t most_waiting) : most_waiting_(most_waiting) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
}

Workers::~Workers() {
  std::deque<Task> dropped;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    dropped.swap(tasks_);
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

bool Workers::submit(std::function<void()> task, const void* tag) {
  {
    const std::lock_guard lock(mutex_);
    if (stopping_ || tasks_.size() >= most_waiting_) return false;
    tasks_.emplace_back(tag, std::move(task));
  }
  changed_.notify_one();
  return true;
}

void Workers::withdraw(const void* tag) {
  std::deque<Task> withdrawn;  // destroyed after the lock
  const std::lock_guard lock(mutex_);
  const auto end = std::stable_partition(tasks_.begin(), tasks_.end(),
                                         [&](const Task& task) { return task.first != tag; });
  withdrawn.assign(std::make_move_iterator(end), std::make_move_iterator(tasks_.end()));
  tasks_.erase(end, tasks_.end());
}

std::size_t Workers::waiting() const {
  const std::lock_guard lock(mutex_);
  return tasks_.size();
}

void Workers::work() {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNiceness);
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopping_ || !tasks_.empty(); });
    if (stopping_) return;
    std::function<void()> task = std::move(tasks_.front().second);
    tasks_.pop_front();
    lock.unlock();
    task();
    task = {};  // what it holds is gone before the next waits
    lock.lock();
  }
}

}  // namespace caustic::service
