// Bytes of a connection in, whole requests out. Holds no more of a request than the limits allow,
// however it comes: byte by byte, endless, or several at once.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "service/http/request_head.h"

namespace caustic::service {

class RequestReader {
 public:
  explicit RequestReader(std::size_t max_body) : max_body_(max_body) {}

  void feed(std::string_view bytes) { buffer_.append(bytes); }

  /// The next whole request, or one with a refusal, after which there is no other: the place where
  /// a next one would begin is not known. Nothing if more bytes are needed.
  std::optional<HttpRequest> next();

  /// Forgets all that has come, and frees its memory.
  void reset();

  /// True, once, if the client waits for "100 Continue" before it sends the body.
  bool take_expectation() { return std::exchange(expectation_, false); }
  /// False if the connection has to end after the request that came last.
  bool keep_alive() const { return head_.keep_alive && !refused_; }
  /// True if nothing of a next request has come.
  bool idle() const { return state_ == State::head && buffer_.empty(); }
  /// Bytes taken but not yet part of a request: they may be one.
  bool has_more() const { return !buffer_.empty() && !refused_; }
  bool in_head() const { return state_ == State::head; }
  std::size_t held() const { return buffer_.capacity() + body_.capacity(); }

 private:
  enum class State { head, length, chunk_size, chunk_data, chunk_end, trailer };

  bool read_head();
  bool take_body_bytes(State after);
  bool read_chunk_size();
  bool read_chunk_end();
  bool read_trailer();
  bool step();
  std::string_view rest() const { return std::string_view(buffer_).substr(at_); }
  void drop_consumed();
  HttpRequest finish();
  HttpRequest refuse(Problem problem);

  std::size_t max_body_;
  State state_ = State::head;
  std::string buffer_;  ///< what has come and is not yet looked at, from at_ on
  std::size_t at_ = 0;
  std::size_t searched_ = 0;  ///< of that: the head's end is not before
  RequestHead head_;
  std::string body_;
  std::uint64_t left_ = 0;     ///< of the body, or of its chunk
  std::uint64_t dropped_ = 0;  ///< bytes of a body that is too large
  std::size_t trailer_ = 0;    ///< bytes of the trailer
  bool too_large_ = false, expectation_ = false, whole_ = false, refused_ = false;
  bool skipped_line_ = false;  ///< before the head
};

/// Of a body over the limit this much more is read and dropped, so that a client that is still
/// sending reads the answer; then the connection ends.
constexpr std::uint64_t kDroppedBytes = 64u << 20;

}  // namespace caustic::service
