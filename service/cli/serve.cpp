#include <fcntl.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <system_error>
#include <thread>

#include "service/cli/command_line.h"
#include "service/cli/commands.h"
#include "service/http/front.h"
#include "service/http/routes.h"
#include "service/http/server.h"

namespace caustic::service {
namespace {

using std::chrono::milliseconds;

/// Of the descriptors for files, pipes and what libraries open.
constexpr rlim_t kOtherDescriptors = 64;
/// For clients to read their last answers: after a second signal, and at least after a first.
constexpr milliseconds kHurriedTime{100}, kLeastFarewell{500};
constexpr milliseconds kLook{2};  // how often it is asked whether what runs has ended

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
/// stops the server's listening. A second signal does not wait for what runs.
class StopOnSignal {
 public:
  explicit StopOnSignal(Server& server)
      : thread_([this, &server] {
          const sigset_t signals = stop_signals();
          int received;
          sigwait(&signals, &received);
          stopping_ = true;
          // The signal may come before the server listens.
          while (!finished_ && !server.is_listening()) std::this_thread::sleep_for(milliseconds(1));
          if (finished_) return;
          server.stop_listening();
          sigwait(&signals, &received);
          hurried_ = true;
        }) {}
  ~StopOnSignal() {
    finished_ = true;
    pthread_kill(thread_.native_handle(), SIGTERM);  // if it waits still
    thread_.join();
  }
  bool stopping() const { return stopping_; }
  bool hurried() const { return hurried_; }

 private:
  std::atomic<bool> stopping_ = false, finished_ = false, hurried_ = false;
  std::thread thread_;
};

/// As many descriptors as are allowed, and no more connections than that.
std::size_t raise_descriptors(std::size_t wanted) {
  rlimit limit;
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return wanted;
  const rlim_t enough = std::min<rlim_t>(limit.rlim_max, wanted + kOtherDescriptors);
  if (limit.rlim_cur < enough) {
    limit.rlim_cur = enough;
    setrlimit(RLIMIT_NOFILE, &limit);
  }
  getrlimit(RLIMIT_NOFILE, &limit);
  return std::min<std::size_t>(wanted,
                               limit.rlim_cur - std::min(limit.rlim_cur, kOtherDescriptors));
}

/// Lets what runs go on for a while, then ends it, and sends what there is to say about it.
void finish(Server& server, Jobs& jobs, const StopOnSignal& stop, milliseconds grace) {
  server.reactor().drain(
      milliseconds(0));  // who is idle may go, who gets an answer is told that it is the last
  const auto deadline = std::chrono::steady_clock::now() + grace;
  const auto busy = [&] { return jobs.running() + jobs.waiting() > 0; };
  while (busy() && !stop.hurried() && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(kLook);
  jobs.interrupt();
  while (jobs.running() > 0) std::this_thread::sleep_for(kLook);
  server.reactor().drain(stop.hurried() ? kHurriedTime : std::max(grace, kLeastFarewell));
}

int listen(Server& server, Jobs& jobs, const ServeOptions& options) {
  const std::string& host = options.server.host;
  const int port = server.bind();
  if (port < 0) {
    std::cerr << "isocaustic: cannot listen on " << host << std::endl;
    return kFailed;
  }
  const StopOnSignal stop(server);
  const bool v6 = host.find(':') != host.npos;
  std::cout << "listening on http://" << (v6 ? "[" + host + "]" : host) << ':' << port << std::endl;
  server.listen();
  if (!stop.stopping()) {
    std::cerr << "isocaustic: the listening socket failed" << std::endl;
    return kFailed;
  }
  finish(server, jobs, stop, milliseconds(options.grace_ms));
  return kDone;
}

/// The first line of the file. Nothing if there is none.
std::string read_token(const std::string& path) {
  std::ifstream in(path);
  std::string token;
  std::getline(in, token);
  while (!token.empty() && (token.back() == '\r' || token.back() == ' ')) token.pop_back();
  return token;
}

Descriptor open_log(const std::string& target) {
  Descriptor file(target == "-"
                      ? dup(STDERR_FILENO)
                      : ::open(target.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
  if (!file) throw std::system_error(errno, std::generic_category(), target);
  return file;
}

int serve_or_throw(ServeOptions options) {
  options.server.reactor.max_connections =
      raise_descriptors(options.server.reactor.max_connections);
  const ResultStore store(
      options.data.empty() ? default_folder() : std::filesystem::path(options.data),
      options.store_megabytes << 20);
  std::unique_ptr<LogLines> log;
  if (options.log != "off") log = std::make_unique<LogLines>(open_log(options.log));
  Metrics metrics;
  const ContourService contours(solver::trace_contours, store, &metrics);
  JobFiles files(store.folder() / "jobs");
  Jobs jobs(options.jobs, &files);
  Routes routes(contours, store, jobs, &metrics);
  const Front front(
      [&routes](HttpRequest request, std::shared_ptr<Exchange> exchange) {
        routes.serve(std::move(request), std::move(exchange));
      },
      options.front, metrics, log.get());
  Server server(front, options.server);
  return listen(server, jobs, options);
}

}  // namespace

int serve(ServeOptions options) {
  if (!is_loopback(options.server.host) && !options.open_to_all) {
    std::cerr << "isocaustic: " << options.server.host
              << " is not a loopback address; --public says that it is meant" << std::endl;
    return kBadInput;
  }
  if (!options.token_file.empty()) {
    options.front.token = read_token(options.token_file);
    if (options.front.token.empty()) {
      std::cerr << "isocaustic: there is no token in " << options.token_file << std::endl;
      return kBadInput;
    }
  }
  const sigset_t signals = stop_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);  // threads to come inherit it
  std::signal(SIGXFSZ, SIG_IGN);                  // a file over the limit is an error of write()
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return serve_or_throw(std::move(options));
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
