#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <system_error>
#include <thread>

#include "service/cli/command_line.h"
#include "service/cli/commands.h"
#include "service/http/server.h"

namespace caustic::service {
namespace {

std::filesystem::path default_folder() {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  if (cache && *cache) return std::filesystem::path(cache) / "isocaustic";
  const char* home = std::getenv("HOME");
  return std::filesystem::path(home && *home ? home : ".") / ".cache" / "isocaustic";
}

bool is_loopback(const std::string& host) {
  return host == "localhost" || host == "::1" || host.starts_with("127.");
}

sigset_t stop_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  return signals;
}

/// Waits in a thread of its own for SIGTERM or SIGINT, which are blocked in all others, and then
/// stops the server and what it computes.
class StopOnSignal {
 public:
  StopOnSignal(Server& server, std::atomic<bool>& stopping)
      : thread_([this, &server, &stopping] {
          const sigset_t signals = stop_signals();
          int received;
          sigwait(&signals, &received);
          stopping = true;
          // The signal may come before the server listens.
          while (!finished_ && !server.is_listening())
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
          if (!finished_) server.stop();
        }) {}
  ~StopOnSignal() {
    finished_ = true;
    pthread_kill(thread_.native_handle(), SIGTERM);  // if it waits still
    thread_.join();
  }

 private:
  std::atomic<bool> finished_ = false;
  std::thread thread_;
};

int listen(Server& server, const std::string& host, std::atomic<bool>& stopping) {
  const int port = server.bind();
  if (port < 0) {
    std::cerr << "isocaustic: cannot listen on " << host << std::endl;
    return kFailed;
  }
  {
    const StopOnSignal stop(server, stopping);
    const bool v6 = host.find(':') != host.npos;
    std::cout << "listening on http://" << (v6 ? "[" + host + "]" : host) << ':' << port
              << std::endl;
    server.listen();
    if (stopping) return kDone;
  }
  std::cerr << "isocaustic: the listening socket failed" << std::endl;
  return kFailed;
}

}  // namespace

int serve(const ServeOptions& options) {
  if (!is_loopback(options.server.host) && !options.open_to_all) {
    std::cerr << "isocaustic: " << options.server.host
              << " is not a loopback address; --public says that it is meant" << std::endl;
    return kBadInput;
  }
  const sigset_t signals = stop_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);  // threads to come inherit it
  std::signal(SIGXFSZ, SIG_IGN);                  // a file over the limit is an error of write()
  std::signal(SIGPIPE, SIG_IGN);
  try {
    std::atomic<bool> stopping = false;
    const ResultStore store(options.data.empty() ? default_folder()
                                                 : std::filesystem::path(options.data));
    const ContourService contours(solver::trace_contours, store, &stopping);
    const Routes routes(contours, store, &stopping);
    Server server(routes, options.server);
    return listen(server, options.server.host, stopping);
  } catch (const std::system_error& error) {
    std::cerr << "isocaustic: " << error.what() << std::endl;
    return kFailed;
  }
}

int check_health(const std::string& host, int port) {
  const bool healthy = is_healthy(host, port);
  (healthy ? std::cout << "ok" : std::cerr << "no answer from http://" << host << ':' << port)
      << std::endl;
  return healthy ? kDone : kFailed;
}

}  // namespace caustic::service
