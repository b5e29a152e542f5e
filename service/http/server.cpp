// The only file that includes cpp-httplib. It listens and accepts, and asks for the health of a
// server. What it does with a connection - a thread for each, heads without limits, ranges,
// compression, regular expressions - is not used: connections go to the reactor.
#include "service/http/server.h"

#include <Eigen/Core>  // httplib.h defines _res, so it comes after

#include <httplib.h>

namespace caustic::service {
namespace {

/// Where the library accepts, there it hands over; that takes no thread.
struct AtOnce : httplib::TaskQueue {
  void enqueue(std::function<void()> task) override { task(); }
  void shutdown() override {}
};

}  // namespace

struct Server::Library : httplib::Server {
  explicit Library(Reactor& the_reactor) : reactor(the_reactor) {
    new_task_queue = [] { return new AtOnce; };
    set_socket_options([this](socket_t socket) {
      // The library's own choice, SO_REUSEPORT, lets a second server take half of the first's
      // clients.
      const int yes = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
      listening = socket;
    });
  }

  bool process_and_close_socket(socket_t socket) override {
    reactor.adopt(socket);
    return true;
  }

  Reactor& reactor;
  socket_t listening = INVALID_SOCKET;
};

Server::Server(HttpHandler handler, const ServerOptions& options)
    : options_(options),
      reactor_(std::move(handler), options.reactor),
      library_(std::make_unique<Library>(reactor_)) {}

Server::~Server() = default;

int Server::bind() {
  if (options_.port == 0)
    options_.port = library_->bind_to_any_port(options_.host);
  else if (!library_->bind_to_port(options_.host, options_.port))
    options_.port = -1;
  // The library lets five clients wait; the sixth of a burst would try again after a second.
  if (options_.port >= 0) ::listen(library_->listening, SOMAXCONN);
  return options_.port;
}

bool Server::listen() { return library_->listen_after_bind(); }

bool Server::is_listening() const { return library_->is_running(); }

void Server::stop_listening() { library_->stop(); }

bool is_healthy(const std::string& host, int port) {
  httplib::Client client(host, port);
  client.set_connection_timeout(2);
  client.set_read_timeout(5);
  const auto result = client.Get("/healthz");
  return result && result->status == 200;
}

}  // namespace caustic::service
