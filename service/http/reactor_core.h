// What a reactor's threads and its connections share.
#pragma once

#include <sys/epoll.h>

#include <atomic>
#include <cstdint>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "service/descriptor.h"
#include "service/http/reactor.h"
#include "service/http/request_reader.h"

namespace caustic::service {

using ReactorClock = std::chrono::steady_clock;

struct Reactor::Core {
  Core(HttpHandler the_handler, const ReactorOptions& the_options);

  std::shared_ptr<Connection> find(std::uint64_t id);
  std::vector<std::shared_ptr<Connection>> all();
  void add(std::uint64_t id, std::shared_ptr<Connection> connection);
  void remove(std::uint64_t id);

  const HttpHandler handler;
  const ReactorOptions options;
  Descriptor epoll, wake;  ///< the second tells threads to end
  std::atomic<bool> draining = false;
  std::atomic<std::size_t> count = 0, input = 0, output = 0, streams = 0;
  std::atomic<std::uint64_t> next_id = 1;  ///< 0 is `wake`

 private:
  std::mutex mutex_;  // taken after a connection's own, never before
  std::unordered_map<std::uint64_t, std::shared_ptr<Connection>> connections_;
};

/// A socket, how far its request has come, and how far its answer has gone.
class Reactor::Connection final : public Exchange, public std::enable_shared_from_this<Connection> {
 public:
  Connection(std::shared_ptr<Core> core, std::uint64_t id, int descriptor);
  ~Connection() override;

  void answer(HttpResponse response) override;
  void on_leave(std::function<void()> leave) override;

  void begin();                             ///< watch for the first request
  void handle(std::uint32_t events);        ///< something happened on the socket
  void tick(ReactorClock::time_point now);  ///< time has passed
  void close_now();
  bool close_if_reading();
  /// When it became idle; nothing if it is at work.
  std::optional<ReactorClock::time_point> idle_since();

 private:
  enum class State { reading, answering, writing, streaming, lingering, closed };

  std::optional<HttpRequest> read();
  std::optional<HttpRequest> begin_request(HttpRequest request);
  std::optional<HttpRequest> refuse(int status, const char* detail);
  void dispatch(HttpRequest request);
  void account();
  void flush();
  bool send_some();
  void finish_answer();
  void pump();
  void linger();
  void watch(std::uint32_t events);
  void close();

  const std::shared_ptr<Core> core_;
  const std::uint64_t id_;
  std::mutex mutex_;  // of all below
  int descriptor_;
  std::string peer_;
  State state_ = State::reading;
  RequestReader reader_;
  ReactorClock::time_point started_, deadline_;
  std::size_t input_ = 0, output_ = 0;  ///< our part of the core's sums
  bool keep_ = true, head_only_ = false, refused_ = false;
  std::string head_, body_;
  std::size_t sent_ = 0;  ///< of head and body
  std::size_t discarded_ = 0;
  std::shared_ptr<EventSource> events_;
  std::function<void()> leave_;
};

}  // namespace caustic::service
