// The HTTP server: a listening socket in, connections to the reactor.
#pragma once

#include <memory>
#include <string>

#include "service/http/reactor.h"

namespace caustic::service {

struct ServerOptions {
  std::string host = "127.0.0.1";
  int port = 8080;  ///< 0: a free one
  ReactorOptions reactor;
};

class Server {
 public:
  Server(HttpHandler handler, const ServerOptions& options);
  ~Server();

  /// The port, or -1 if the address cannot be had.
  int bind();
  /// Accepts connections until stop(). False if the listening socket failed.
  bool listen();
  bool is_listening() const;
  /// No more connections. From any thread, once, while it is listening: before that it is without
  /// effect.
  void stop_listening();
  /// Where the connections are.
  Reactor& reactor() { return reactor_; }

 private:
  struct Library;
  ServerOptions options_;
  Reactor reactor_;
  std::unique_ptr<Library> library_;
};

/// GET /healthz of a server. True if it answers that it is well.
bool is_healthy(const std::string& host, int port);

}  // namespace caustic::service
