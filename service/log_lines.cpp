#include "service/log_lines.h"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <utility>

namespace caustic::service {
namespace {

constexpr std::size_t kMostPending = 1u << 20;
constexpr int kLookUp = 100;  // ms, to see whether to stop

}  // namespace

LogLines::LogLines(Descriptor file) : file_(std::move(file)), thread_([this] { work(); }) {}

LogLines::~LogLines() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void LogLines::write(std::string line) {
  {
    const std::lock_guard lock(mutex_);
    if (pending_.size() + line.size() > kMostPending) {
      ++lost_;
      return;
    }
    if (lost_ > 0) pending_ += "{\"lost_lines\":" + std::to_string(std::exchange(lost_, 0)) + "}\n";
    pending_ += line += '\n';
  }
  changed_.notify_one();
}

/// A pipe that is ready takes PIPE_BUF bytes without blocking; files are always ready.
bool LogLines::write_now(const std::string& text) const {
  std::size_t done = 0;
  while (done < text.size()) {
    pollfd ready{file_.get(), POLLOUT, 0};
    if (poll(&ready, 1, kLookUp) != 1 || !(ready.revents & POLLOUT)) return false;
    const std::size_t count = std::min<std::size_t>(PIPE_BUF, text.size() - done);
    const ssize_t written = ::write(file_.get(), text.data() + done, count);
    if (written < 0 && errno != EINTR) return false;
    if (written > 0) done += static_cast<std::size_t>(written);
  }
  return true;
}

void LogLines::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopping_ || !pending_.empty(); });
    if (pending_.empty()) return;
    std::string text;
    text.swap(pending_);
    lock.unlock();
    const bool written = write_now(text);
    lock.lock();
    if (!written && stopping_) return;
  }
}

}  // namespace caustic::service
