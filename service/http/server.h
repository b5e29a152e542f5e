// The HTTP server: sockets in, Routes::answer() out.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "service/http/routes.h"

namespace caustic::service {

struct ServerOptions {
  std::string host = "127.0.0.1";
  int port = 8080;  ///< 0: a free one
  std::size_t max_body = 8u << 20;
  int threads = 8;  ///< connections served at a time
};

class Server {
 public:
  Server(const Routes& routes, const ServerOptions& options);
  ~Server();

  /// The port, or -1 if the address cannot be had.
  int bind();
  /// Serves until stop(); returns when every running answer has been sent.
  bool listen();
  bool is_listening() const;
  /// From any thread, once, while it is listening: before that it is without effect.
  void stop();

 private:
  struct Library;
  ServerOptions options_;
  std::unique_ptr<Library> library_;
};

/// GET /healthz of a server. True if it answers that it is well.
bool is_healthy(const std::string& host, int port);

}  // namespace caustic::service
