// The only file that includes cpp-httplib. Of its routing nothing is used: every request, whatever
// its path, comes to Routes::answer(). What the library does by itself and should not (ranges,
// compression, decoding of paths, regular expressions) is switched off before it acts.
#include "service/http/server.h"

#include <Eigen/Core>  // httplib.h defines _res, so it comes after

#include <httplib.h>

#include <charconv>
#include <filesystem>
#include <thread>

namespace caustic::service {
namespace {

/// Of a body over the limit this much more is read and dropped, so that a client that is still
/// sending gets the answer; then the connection is closed.
constexpr std::size_t kDrained = 64u << 20;

constexpr std::size_t kKeepAliveRequests = 100'000;
constexpr int kIdleSeconds = 5;

/// Sends the body, then makes the library close the connection: it does so when a provider fails,
/// and has no other way.
void send_and_close(httplib::Response& out, HttpResponse&& in) {
  const auto body = std::make_shared<std::string>(std::move(in.body));
  out.set_header("Connection", "close");
  out.set_content_provider(body->size(), in.content_type.c_str(),
                           [body](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
                             sink.write(body->data() + offset, length);
                             return false;
                           });
}

void send(httplib::Response& out, HttpResponse&& in, bool close) {
  out.status = in.status;
  for (const auto& [name, value] : in.headers) out.set_header(name.c_str(), value);
  if (close) return send_and_close(out, std::move(in));
  out.set_header("Content-Type", in.content_type);
  out.body = std::move(in.body);
}

HttpRequest head_of(const httplib::Request& request) {
  return {request.method, request.target, request.get_header_value("Content-Type"), {}, false};
}

/// How the body comes. `unsound`: its end cannot be told for sure, so the connection must end.
enum class Framing { none, readable, too_large, unsound };

Framing framing_of(const httplib::Request& request, std::size_t max_body) {
  const auto lengths = request.get_header_value_count("Content-Length");
  const auto codings = request.get_header_value_count("Transfer-Encoding");
  if (lengths + codings == 0) return Framing::none;
  if (lengths + codings > 1) return Framing::unsound;
  if (codings) {
    const bool chunked = request.get_header_value("Transfer-Encoding") == "chunked";
    return chunked ? Framing::readable : Framing::unsound;
  }
  const std::string text = request.get_header_value("Content-Length");
  std::size_t length = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), length);
  if (error == std::errc::result_out_of_range) return Framing::too_large;
  if (error != std::errc() || end != text.data() + text.size()) return Framing::unsound;
  return length > max_body + kDrained ? Framing::too_large : Framing::readable;
}

/// Reads the body up to the limit. False if the connection cannot be used any more.
bool read_body(const httplib::ContentReader& reader, std::size_t max_body, HttpRequest& request) {
  std::size_t dropped = 0;
  const bool whole = reader([&](const char* data, std::size_t size) {
    if (!request.body_too_large && request.body.size() + size <= max_body) {
      request.body.append(data, size);
      return true;
    }
    request.body_too_large = true;
    request.body = {};
    return (dropped += size) <= kDrained;
  });
  return whole;
}

/// The port of this end, 0 if the descriptor is none of a connection.
int port_of_connection(int descriptor) {
  sockaddr_storage own{}, peer{};
  socklen_t own_size = sizeof own, peer_size = sizeof peer;
  if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&peer), &peer_size) != 0) return 0;
  if (getsockname(descriptor, reinterpret_cast<sockaddr*>(&own), &own_size) != 0) return 0;
  if (own.ss_family == AF_INET) return ntohs(reinterpret_cast<sockaddr_in&>(own).sin_port);
  if (own.ss_family == AF_INET6) return ntohs(reinterpret_cast<sockaddr_in6&>(own).sin6_port);
  return 0;
}

/// Lets every connection of this port find that its client says no more. The library does not tell
/// its connections, and one that waits for a request looks up only after kIdleSeconds.
void hang_up_on_all(int port) {
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int descriptor = std::stoi(entry.path().filename());
    if (port_of_connection(descriptor) == port) ::shutdown(descriptor, SHUT_RD);
  }
}

}  // namespace

struct Server::Library : httplib::Server {
  /// Requests whose answers are under way. From request to answer a thread stays the same.
  std::atomic<int> answering = 0;
  std::atomic<bool> finished = false;
  static thread_local bool answering_here;

  void begin_answer() {
    if (!std::exchange(answering_here, true)) ++answering;
  }
  void end_answer() {
    if (std::exchange(answering_here, false)) --answering;
  }
};
thread_local bool Server::Library::answering_here = false;

Server::Server(const Routes& routes, const ServerOptions& options)
    : options_(options), library_(std::make_unique<Library>()) {
  library_->new_task_queue = [n = options.threads] { return new httplib::ThreadPool(n); };
  library_->set_tcp_nodelay(true);
  library_->set_socket_options([](socket_t socket) {
    // The library's own choice, SO_REUSEPORT, lets a second server take half of the first's
    // clients.
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  library_->set_keep_alive_max_count(kKeepAliveRequests);
  library_->set_keep_alive_timeout(kIdleSeconds);

  library_->set_exception_handler([](const auto&, httplib::Response& out, std::exception_ptr) {
    send(out, problem_response(make_problem(500, "internal error")), true);  // its text stays here
  });

  using Handled = httplib::Server::HandlerResponse;
  library_->set_logger([this](const auto&, const auto&) { library_->end_answer(); });
  library_->set_pre_routing_handler([this, &routes](const auto& in, httplib::Response& out) {
    library_->begin_answer();
    auto& request = const_cast<httplib::Request&>(in);  // the library's own object, and not const
    request.ranges.clear();
    request.headers.erase("Accept-Encoding");
    request.path.assign(1, '/');  // all that the library's routing sees
    const bool library_reads_a_body =
        in.method == "POST" || in.method == "PUT" || in.method == "PATCH" || in.method == "DELETE";
    if (library_reads_a_body) return Handled::Unhandled;
    send(out, routes.answer(head_of(in)), false);
    return Handled::Handled;
  });

  const auto with_body = [&routes, max_body = options.max_body](
                             const httplib::Request& in, httplib::Response& out,
                             const httplib::ContentReader& reader) {
    HttpRequest request = head_of(in);
    // The library would take a multipart body apart, for a receiver that is not there.
    const_cast<httplib::Request&>(in).headers.erase("Content-Type");
    const Framing framing = framing_of(in, max_body);
    if (framing == Framing::unsound)
      return send(out, problem_response(make_problem(400, "the length of the body is unclear")),
                  true);
    request.body_too_large = framing == Framing::too_large;
    const bool whole = framing == Framing::none ||
                       (framing == Framing::readable && read_body(reader, max_body, request));
    if (!whole && !request.body_too_large)
      return send(out, problem_response(make_problem(400, "the body is not whole")), true);
    send(out, routes.answer(request), !whole);
  };
  library_->Post("/", with_body);
  library_->Put("/", with_body);
  library_->Patch("/", with_body);
  library_->Delete("/", with_body);
}

Server::~Server() = default;

int Server::bind() {
  if (options_.port == 0)
    options_.port = library_->bind_to_any_port(options_.host);
  else if (!library_->bind_to_port(options_.host, options_.port))
    options_.port = -1;
  return options_.port;
}

bool Server::listen() {
  const bool stopped = library_->listen_after_bind();
  library_->finished = true;
  return stopped;
}

bool Server::is_listening() const { return library_->is_running(); }

void Server::stop() {
  library_->stop();
  while (library_->answering > 0 && !library_->finished)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  hang_up_on_all(options_.port);
}

bool is_healthy(const std::string& host, int port) {
  httplib::Client client(host, port);
  client.set_connection_timeout(2);
  client.set_read_timeout(5);
  const auto result = client.Get("/healthz");
  return result && result->status == 200;
}

}  // namespace caustic::service
