#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "service/api/problem.h"
#include "service/http/reactor_core.h"
#include "service/http/response_head.h"
#include "service/http/routes.h"

namespace caustic::service {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::size_t kReadBytes = 16384;
constexpr int kReadsAtATime = 8;  // then others have their turn
/// An answer must be read in this time and 1 s more for each so many bytes.
constexpr auto kWriteTime = seconds(30);
constexpr std::size_t kSlowestReader = 32768;
/// After a refusal what the client still sends is dropped for a while: closing at once would reset
/// the connection, and with it the answer that is on its way.
constexpr auto kLingerTime = seconds(5);
constexpr std::size_t kLingerBytes = 64u << 20;
constexpr std::size_t kStreamBacklog = 65536;  // of events that a client has not read

std::string address_of_peer(int descriptor) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  char text[INET6_ADDRSTRLEN] = "";
  if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  if (address.ss_family == AF_INET)
    inet_ntop(AF_INET, &reinterpret_cast<sockaddr_in&>(address).sin_addr, text, sizeof text);
  if (address.ss_family == AF_INET6)
    inet_ntop(AF_INET6, &reinterpret_cast<sockaddr_in6&>(address).sin6_addr, text, sizeof text);
  return text;
}

/// Assigning empty strings would keep their memory.
void release(std::string& head, std::string& body) {
  std::string().swap(head);
  std::string().swap(body);
}

bool would_block() { return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR; }

}  // namespace

Reactor::Connection::Connection(std::shared_ptr<Core> core, std::uint64_t id, int descriptor)
    : core_(std::move(core)),
      id_(id),
      descriptor_(descriptor),
      peer_(address_of_peer(descriptor)),
      reader_(core_->options.max_body),
      started_(ReactorClock::now()),
      deadline_(started_ + core_->options.head_time) {
  const int yes = 1;
  setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
}

Reactor::Connection::~Connection() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void Reactor::Connection::begin() {
  const std::lock_guard lock(mutex_);
  epoll_event event{EPOLLIN | EPOLLONESHOT, {.u64 = id_}};
  if (epoll_ctl(core_->epoll.get(), EPOLL_CTL_ADD, descriptor_, &event) != 0) close();
}

void Reactor::Connection::watch(std::uint32_t events) {
  epoll_event event{events | EPOLLONESHOT, {.u64 = id_}};
  if (epoll_ctl(core_->epoll.get(), EPOLL_CTL_MOD, descriptor_, &event) != 0) close();
}

void Reactor::Connection::close() {
  if (state_ == State::closed) return;
  ::close(std::exchange(descriptor_, -1));
  if (events_) --core_->streams;
  core_->input -= std::exchange(input_, 0);
  core_->output -= std::exchange(output_, 0);
  state_ = State::closed;
  events_ = {};
  release(head_, body_);
  core_->remove(id_);
}

void Reactor::Connection::close_now() {
  std::function<void()> leave;
  const std::lock_guard lock(mutex_);
  leave.swap(leave_);
  close();
}

bool Reactor::Connection::close_if_reading() {
  const std::lock_guard lock(mutex_);
  if (state_ != State::reading) return false;
  close();
  return true;
}

std::optional<ReactorClock::time_point> Reactor::Connection::idle_since() {
  const std::lock_guard lock(mutex_);
  if (state_ != State::reading || !reader_.idle()) return std::nullopt;
  return started_;
}

void Reactor::Connection::handle(std::uint32_t events) {
  std::optional<HttpRequest> request;
  std::function<void()> leave;
  {
    const std::lock_guard lock(mutex_);
    switch (state_) {
      case State::reading:
        request = read();
        break;
      case State::answering:
        // Its client says no more, so it is gone: nobody else ends its side before the answer.
        if (!(events & (EPOLLRDHUP | EPOLLHUP | EPOLLERR))) break;
        keep_ = false;
        leave.swap(leave_);
        break;
      case State::writing:
        flush();
        break;
      case State::streaming:
        close();
        break;
      case State::lingering:
        linger();
        break;
      case State::closed:
        break;
    }
  }
  if (leave) leave();
  if (request) dispatch(std::move(*request));
}

// ---- Reading
// -------------------------------------------------------------------------------------

std::optional<HttpRequest> Reactor::Connection::read() {
  if (auto request = reader_.next()) return begin_request(std::move(*request));
  std::array<char, kReadBytes> bytes;
  for (int i = 0; i < kReadsAtATime; ++i) {
    const ssize_t count = recv(descriptor_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count < 0 && would_block()) break;
    if (count <= 0) return close(), std::nullopt;
    if (reader_.idle()) started_ = ReactorClock::now();
    reader_.feed({bytes.data(), static_cast<std::size_t>(count)});
    if (auto request = reader_.next()) return begin_request(std::move(*request));
    if (static_cast<std::size_t>(count) < bytes.size()) break;
  }
  account();
  if (core_->input > core_->options.max_input && input_ > kReadBytes)
    return refuse(503, "too many requests are under way");
  if (reader_.take_expectation()) {
    constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
    if (::send(descriptor_, kContinue.data(), kContinue.size(), MSG_NOSIGNAL | MSG_DONTWAIT) < 0)
      return close(), std::nullopt;
  }
  if (!reader_.idle())
    deadline_ =
        started_ + (reader_.in_head() ? core_->options.head_time : core_->options.body_time);
  watch(EPOLLIN);
  return std::nullopt;
}

void Reactor::Connection::account() {
  const std::size_t held = reader_.held();
  core_->input += held - input_;  // wraps round where it shrinks
  input_ = held;
}

std::optional<HttpRequest> Reactor::Connection::begin_request(HttpRequest request) {
  account();
  state_ = State::answering;
  refused_ = request.refusal.has_value();
  keep_ = reader_.keep_alive() && !refused_;
  head_only_ = request.method == "HEAD";
  request.peer = peer_;
  if (!refused_ && core_->output > core_->options.max_output) {
    request.refusal = make_problem(503, "too many answers wait for their clients");
    refused_ = true, keep_ = false;
  }
  return request;
}

std::optional<HttpRequest> Reactor::Connection::refuse(int status, const char* detail) {
  HttpRequest request;
  request.refusal = make_problem(status, detail);
  reader_.reset();
  return begin_request(std::move(request));
}

/// Without the lock: the handler may answer at once.
void Reactor::Connection::dispatch(HttpRequest request) {
  core_->handler(std::move(request), shared_from_this());
  const std::lock_guard lock(mutex_);
  if (state_ == State::answering) watch(EPOLLRDHUP);
}

void Reactor::Connection::on_leave(std::function<void()> leave) {
  const std::lock_guard lock(mutex_);
  if (state_ == State::answering) leave_ = std::move(leave);
}

// ---- Answering
// -----------------------------------------------------------------------------------

void Reactor::Connection::answer(HttpResponse response) {
  std::function<void()> unused;  // destroyed after the lock
  const std::lock_guard lock(mutex_);
  unused.swap(leave_);
  if (state_ != State::answering) return;
  if (response.events) {
    if (++core_->streams > core_->options.max_streams) {
      --core_->streams;
      response = problem_response(make_problem(503, "too many streams: ask for the job itself"));
    } else {
      events_ = response.events;
    }
  }
  if (response.events || core_->draining) keep_ = false;
  head_ = response_head(response, keep_);
  body_ = head_only_ ? std::string() : std::move(response.body);
  sent_ = 0;
  output_ = head_.size() + body_.size();
  core_->output += output_;
  state_ = State::writing;
  deadline_ = ReactorClock::now() + kWriteTime + seconds(output_ / kSlowestReader);
  flush();
}

/// True once all has been sent. False: the socket takes no more now, or is closed.
bool Reactor::Connection::send_some() {
  while (sent_ < head_.size() + body_.size()) {
    iovec parts[2];
    int count = 0;
    if (sent_ < head_.size()) parts[count++] = {head_.data() + sent_, head_.size() - sent_};
    const std::size_t of_body = sent_ - std::min(sent_, head_.size());
    if (of_body < body_.size()) parts[count++] = {body_.data() + of_body, body_.size() - of_body};
    msghdr message{};
    message.msg_iov = parts;
    message.msg_iovlen = static_cast<std::size_t>(count);
    const ssize_t sent = sendmsg(descriptor_, &message, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && would_block()) return false;
    if (sent < 0) return close(), false;
    sent_ += static_cast<std::size_t>(sent);
  }
  return true;
}

void Reactor::Connection::flush() {
  if (send_some()) return finish_answer();
  if (state_ == State::writing) watch(EPOLLOUT);
}

void Reactor::Connection::finish_answer() {
  core_->output -= std::exchange(output_, 0);
  release(head_, body_);
  sent_ = 0;
  if (events_) {
    state_ = State::streaming;
    pump();
    if (state_ == State::streaming) watch(EPOLLRDHUP);
    return;
  }
  if (!keep_ && (refused_ || reader_.has_more())) {
    shutdown(descriptor_, SHUT_WR);
    state_ = State::lingering;
    deadline_ = ReactorClock::now() + kLingerTime;
    return watch(EPOLLIN);
  }
  if (!keep_) return close();
  state_ = State::reading;
  started_ = ReactorClock::now();
  deadline_ = started_ + (reader_.idle() ? core_->options.idle_time : core_->options.head_time);
  // A next request may be here already; then the socket need not have more for us to go on.
  watch(reader_.has_more() ? EPOLLIN | EPOLLOUT : EPOLLIN);
}

void Reactor::Connection::linger() {
  std::array<char, kReadBytes> bytes;
  for (int i = 0; i < kReadsAtATime; ++i) {
    const ssize_t count = recv(descriptor_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count < 0 && would_block()) break;
    if (count <= 0) return close();
    discarded_ += static_cast<std::size_t>(count);
    if (discarded_ > kLingerBytes) return close();
  }
  watch(EPOLLIN);
}

/// Sends what the source of events has; what the client does not take waits for the next time.
void Reactor::Connection::pump() {
  body_.erase(0, std::exchange(sent_, 0));
  const bool more = events_->next(body_);
  const bool all_sent = send_some();
  if (state_ == State::closed) return;
  if (!more || body_.size() - sent_ > kStreamBacklog) return close();
  if (all_sent) body_.clear(), sent_ = 0;
}

void Reactor::Connection::tick(ReactorClock::time_point now) {
  std::optional<HttpRequest> request;
  {
    const std::lock_guard lock(mutex_);
    if (state_ == State::streaming) return pump();
    if (state_ == State::answering || state_ == State::closed || now < deadline_) return;
    if (state_ == State::reading && !reader_.idle())
      request = refuse(408, "the request took too long to come");
    else
      close();
  }
  if (request) dispatch(std::move(*request));
}

}  // namespace caustic::service
