#include "tests/stress/batches.h"

#include <poll.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <vector>

namespace caustic::stress {
namespace {

// A child that says nothing for so long waits for something that does not come.
constexpr int kSilenceMs = 600'000;

struct Child {
  pid_t pid;
  int pipe;
  std::uint64_t next, end;  // the scene it is at, and where it stops
  std::string unread;
};

Child start(std::uint64_t first, std::uint64_t end, const Work& work) {
  int ends[2];
  if (pipe(ends) != 0) throw std::system_error(errno, std::generic_category(), "pipe");
  std::fflush(nullptr);
  const pid_t pid = fork();
  if (pid < 0) throw std::system_error(errno, std::generic_category(), "fork");
  if (pid == 0) {
    close(ends[0]);
    for (std::uint64_t k = first; k < end; ++k) work(k, Voice(ends[1]));
    std::_Exit(0);
  }
  close(ends[1]);
  return {pid, ends[0], first, end, {}};
}

std::string reason(int status) {
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF) return "out of time";
  if (WIFSIGNALED(status)) return std::string("signal ") + strsignal(WTERMSIG(status));
  return "exit status " + std::to_string(WEXITSTATUS(status));
}

/// False when the child has said everything.
bool listen_to(Child& child, const Listener& listener) {
  char buffer[65536];
  const ssize_t n = read(child.pipe, buffer, sizeof buffer);
  if (n <= 0) return false;
  child.unread.append(buffer, static_cast<std::size_t>(n));
  for (std::size_t end; (end = child.unread.find('\n')) != std::string::npos;) {
    const auto line = nlohmann::json::parse(child.unread.substr(0, end));
    child.unread.erase(0, end + 1);
    listener(child.next, line);
    if (line.contains("done")) ++child.next;
  }
  return true;
}

}  // namespace

void Voice::say(const nlohmann::json& line, int seconds) const {
  const std::string bytes = line.dump() + "\n";
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t n = write(descriptor_, bytes.data() + at, bytes.size() - at);
    if (n <= 0) std::_Exit(3);  // nobody listens
    at += static_cast<std::size_t>(n);
  }
  const itimerval allowed{{0, 0}, {seconds, 0}};
  setitimer(ITIMER_PROF, &allowed, nullptr);
}

void run_batches(const BatchPlan& plan, const Work& work, const Listener& listener) {
  std::uint64_t next = plan.first;
  const std::uint64_t end = plan.first + plan.count;
  std::vector<Child> children;
  const auto begin = std::chrono::steady_clock::now();
  const auto has_time = [&] {
    return std::chrono::steady_clock::now() - begin <
           std::chrono::duration<double>(60.0 * plan.minutes);
  };
  while ((next < end && has_time()) || !children.empty()) {
    while (next < end && has_time() && std::ssize(children) < plan.jobs) {
      const std::uint64_t stop = std::min(end, next + plan.size);
      children.push_back(start(next, stop, work));
      next = stop;
    }
    std::vector<pollfd> waiting;
    for (const Child& child : children) waiting.push_back({child.pipe, POLLIN, 0});
    const int ready = poll(waiting.data(), waiting.size(), kSilenceMs);
    for (std::size_t i = children.size(); i-- > 0;) {
      Child& child = children[i];
      if (ready == 0) kill(child.pid, SIGKILL);
      if (ready != 0 && waiting[i].revents == 0) continue;
      if (listen_to(child, listener)) continue;
      int status = 0;
      close(child.pipe);
      waitpid(child.pid, &status, 0);
      const Child ended = child;
      children.erase(children.begin() + static_cast<std::ptrdiff_t>(i));
      if (ended.next >= ended.end) continue;
      listener(ended.next, {{"died", reason(status)}});
      if (ended.next + 1 < ended.end) children.push_back(start(ended.next + 1, ended.end, work));
    }
  }
}

}  // namespace caustic::stress
