// Many connections on few threads. No thread waits for a client: a connection that is idle, slow to
// send or slow to read is a descriptor and what it has sent so far, watched by epoll. A thread
// takes it up when there is something to do, hands a whole request to the handler, and leaves it
// when it would block. Each connection is armed for one event at a time, so one thread is at work
// on it.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>

#include "service/http/message.h"

namespace caustic::service {

struct ReactorOptions {
  int threads = 4;
  std::size_t max_body = 8u << 20;
  std::size_t max_connections = 2048;   ///< then the one that is idle for longest makes room
  std::size_t max_streams = 64;         ///< of events, at a time
  std::size_t max_input = 24u << 20;    ///< bytes of all requests that are not whole yet
  std::size_t max_output = 256u << 20;  ///< bytes of all answers that clients have not read yet
  std::chrono::milliseconds head_time{10'000};  ///< from a head's first byte to its last
  std::chrono::milliseconds body_time{60'000};  ///< the same for a body
  std::chrono::milliseconds idle_time{60'000};  ///< between two requests
};

class Reactor {
 public:
  /// Throws std::system_error if the system has no descriptors for it.
  Reactor(HttpHandler handler, const ReactorOptions& options);
  /// Closes every connection. Answers that come later lead nowhere.
  ~Reactor();

  /// Takes over a connected socket.
  void adopt(int descriptor);
  /// No more requests: idle connections are closed, others after the answer that is under way.
  /// Returns when none is left, or after this time.
  void drain(std::chrono::milliseconds patience);

  std::size_t connections() const;

 private:
  struct Core;
  class Connection;
  struct Threads;
  std::shared_ptr<Core> core_;
  std::unique_ptr<Threads> threads_;
};

}  // namespace caustic::service
