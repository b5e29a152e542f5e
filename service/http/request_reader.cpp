#include "service/http/request_reader.h"

#include <algorithm>
#include <charconv>

namespace caustic::service {
namespace {

constexpr std::size_t kMaxChunkLine = 256;  // size and extensions, which are ignored
constexpr std::size_t kMaxTrailer = 4096;

/// Assigning an empty string would keep the memory.
void release(std::string& text) { std::string().swap(text); }

[[noreturn]] void refuse_body(int status, const char* detail) {
  throw ProblemError(make_problem(status, detail));
}

}  // namespace

/// Each step consumes some of the buffer, or returns false to wait for more.
std::optional<HttpRequest> RequestReader::next() {
  if (refused_) return std::nullopt;
  try {
    while (!whole_ && step()) {
    }
  } catch (const ProblemError& error) {
    return refuse(error.problem());
  }
  drop_consumed();
  if (!whole_) return std::nullopt;
  return finish();
}

/// Once for all steps: a body in tiny chunks would else be moved as often as it has chunks.
void RequestReader::drop_consumed() {
  buffer_.erase(0, std::exchange(at_, 0));
  if (buffer_.empty() && (state_ == State::head || whole_)) release(buffer_);  // idle holds nothing
}

/// Assigned to, the strings would keep what they have allocated.
void RequestReader::reset() {
  RequestReader fresh(max_body_);
  std::swap(*this, fresh);
}

bool RequestReader::step() {
  switch (state_) {
    case State::head:
      return read_head();
    case State::length:
      if (left_ > 0) return take_body_bytes(State::length);
      return whole_ = true;
    case State::chunk_size:
      return read_chunk_size();
    case State::chunk_data:
      return take_body_bytes(State::chunk_end);
    case State::chunk_end:
      return read_chunk_end();
    case State::trailer:
      return read_trailer();
  }
  return false;
}

bool RequestReader::read_head() {
  // An empty line before a request is a leftover of the one before (RFC 9112, 2.2).
  if (rest() == "\r") return false;
  if (!skipped_line_ && searched_ == 0 && rest().starts_with("\r\n")) {
    at_ += 2;
    skipped_line_ = true;
  }
  const std::string_view bytes = rest();
  if (bytes.starts_with("\r\n")) refuse_body(400, "the request line is not one");
  const auto end = bytes.find("\r\n\r\n", searched_ > 3 ? searched_ - 3 : 0);
  if (std::min(end, bytes.size()) > kMaxHeadBytes) refuse_body(431, "the head is too large");
  if (end == bytes.npos) {
    // Whatever follows, this is no head of ours: say so now.
    const auto feed = bytes.find('\n');
    if (feed == 0 || (feed != bytes.npos && bytes[feed - 1] != '\r'))
      refuse_body(400, "a line of the head does not end in CRLF");
    if (feed == bytes.npos && bytes.size() > kMaxTargetBytes + 40)
      refuse_body(414, "the path is too long");
    searched_ = bytes.size();
    return false;
  }
  head_ = {};
  head_ = parse_request_head(bytes.substr(0, end + 4));
  at_ += end + 4;
  searched_ = 0;
  left_ = head_.length.value_or(0);
  state_ = head_.chunked ? State::chunk_size : State::length;
  too_large_ = left_ > max_body_;
  // Who asks before sending is told before sending; a body that is longer than what is dropped
  // will not be read to its end.
  if (too_large_ && (head_.expects_continue || left_ > max_body_ + kDroppedBytes))
    refuse_body(413, "the body is too large");
  expectation_ = head_.expects_continue;
  return true;
}

bool RequestReader::take_body_bytes(State after) {
  const std::size_t count = std::min<std::uint64_t>(left_, rest().size());
  if (count == 0) return false;
  if (!too_large_ && body_.size() + count > max_body_) too_large_ = true;
  if (!too_large_) {
    body_.append(rest().substr(0, count));
  } else {
    release(body_);
    dropped_ += count;
    if (dropped_ > max_body_ + kDroppedBytes) refuse_body(413, "the body is too large");
  }
  at_ += count;
  left_ -= count;
  if (left_ == 0) state_ = after;
  return true;
}

bool RequestReader::read_chunk_size() {
  const auto end = rest().find("\r\n");
  if (std::min(end, rest().size()) > kMaxChunkLine) refuse_body(400, "a chunk has no size");
  if (end == std::string_view::npos) return false;
  const std::string_view line = rest().substr(0, end);
  const auto [stop, error] = std::from_chars(line.data(), line.data() + end, left_, 16);
  const std::string_view extension = line.substr(static_cast<std::size_t>(stop - line.data()));
  const bool sound = extension.empty() || extension.starts_with(';');
  if (error != std::errc() || !sound || extension.find_first_of("\r\n") != line.npos ||
      extension.find('\0') != line.npos)
    refuse_body(400, "a chunk has no size");
  at_ += end + 2;
  state_ = left_ > 0 ? State::chunk_data : State::trailer;
  return true;
}

bool RequestReader::read_chunk_end() {
  if (rest().size() < 2) return false;
  if (!rest().starts_with("\r\n")) refuse_body(400, "a chunk is longer than it says");
  at_ += 2;
  state_ = State::chunk_size;
  return true;
}

/// What is in a trailer is of no use to us, but it must end.
bool RequestReader::read_trailer() {
  const auto end = rest().find("\r\n");
  if (trailer_ + std::min(end, rest().size()) > kMaxTrailer)
    refuse_body(431, "the trailer is too large");
  if (end == std::string_view::npos) return false;
  trailer_ += end;
  const std::string_view line = rest().substr(0, end);
  if (line.find_first_of("\n\r") != line.npos || line.find('\0') != line.npos)
    refuse_body(400, "the trailer is not one");
  whole_ = end == 0;
  at_ += end + 2;
  return true;
}

HttpRequest RequestReader::finish() {
  HttpRequest request;
  request.method = std::move(head_.method);
  request.target = std::move(head_.target);
  request.headers = std::move(head_.headers);
  request.content_type = request.header("content-type");
  request.body = std::move(body_);
  request.body_too_large = too_large_;
  release(body_);
  state_ = State::head;
  dropped_ = trailer_ = 0;
  whole_ = too_large_ = skipped_line_ = false;
  return request;
}

HttpRequest RequestReader::refuse(Problem problem) {
  refused_ = true;
  release(buffer_);
  at_ = 0;
  HttpRequest request;
  request.method = std::move(head_.method);
  request.target = std::move(head_.target);
  request.refusal = std::move(problem);
  release(body_);
  return request;
}

}  // namespace caustic::service
