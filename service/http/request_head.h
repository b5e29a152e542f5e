// The head of a request, read strictly: what two readers could understand differently is refused,
// so that no proxy in front and no reader behind sees other requests than this one does.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "service/http/message.h"

namespace caustic::service {

constexpr std::size_t kMaxHeadBytes = 16384;
constexpr std::size_t kMaxTargetBytes = 4096;
constexpr std::size_t kMaxHeaders = 100;
constexpr std::size_t kMaxRanges = 16;

struct RequestHead {
  std::string method, target;
  HttpHeaders headers;  ///< names in lower case; those with an underscore are left out
  bool keep_alive = true;
  bool expects_continue = false;
  bool chunked = false;
  std::optional<std::uint64_t> length;  ///< of the body; neither this nor chunked: no body

  std::string_view header(std::string_view name) const;
};

/// `bytes` is all of the head, the empty line included. Throws ProblemError.
///
/// - lines end in CRLF; no other CR, LF or control character, no folded line
/// - `METHOD SP target SP HTTP/1.0|1.1`: upper-case letters, visible ASCII, single spaces
/// - names are tokens, followed by their colon at once; at most kMaxHeaders of them
/// - the body has one length: one Content-Length of digits, or `Transfer-Encoding: chunked`, not
///   both; GET, HEAD, DELETE, OPTIONS and TRACE have no body
/// - what may come once comes once: Host, Content-Type, Authorization, …; Host does come in
/// HTTP/1.1
/// - `Range` lists at most kMaxRanges parts (416; RFC 9110, 15.5.17). None are served: who asks for
///   fewer gets the whole
/// - bodies are not coded (415), and nothing else is expected than 100-continue (417)
RequestHead parse_request_head(std::string_view bytes);

}  // namespace caustic::service
