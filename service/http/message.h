// A request and its response, and the way back to the client, free of sockets and of the library.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "service/api/problem.h"

namespace caustic::service {

using HttpHeaders = std::vector<std::pair<std::string, std::string>>;

struct HttpRequest {
  std::string method;
  std::string target;  ///< as sent, not decoded
  std::string content_type;
  std::string body;
  bool body_too_large = false;  ///< the body was longer than allowed and is not kept
  HttpHeaders headers = {};     ///< names in lower case, values trimmed, as sent else
  std::string id = {};          ///< under which the log has it and the answer tells it
  std::string peer = {};        ///< address of the client
  /// Not a request that can be served: this is what is wrong with its head, body or pace. The
  /// connection ends with the answer.
  std::optional<Problem> refusal = {};

  /// The value of this header (lower case), empty if there is none.
  std::string_view header(std::string_view name) const {
    for (const auto& [key, value] : headers)
      if (key == name) return value;
    return {};
  }
};

/// What a stream of events sends, whenever it is asked.
class EventSource {
 public:
  virtual ~EventSource() = default;
  /// Appends what is new. False if nothing will follow.
  virtual bool next(std::string& out) = 0;
};

struct HttpResponse {
  int status = 200;
  std::string content_type;
  std::string body;
  HttpHeaders headers;
  /// Instead of a body: sent bit by bit until it ends, or the client leaves.
  std::shared_ptr<EventSource> events = {};
};

/// One request's way back. Safe for any thread.
class Exchange {
 public:
  virtual ~Exchange() = default;
  /// To be called once.
  virtual void answer(HttpResponse response) = 0;
  /// Calls `leave`, from another thread, if the client goes before it is answered.
  virtual void on_leave(std::function<void()> leave) = 0;
};

/// Answers now or later, but always.
using HttpHandler = std::function<void(HttpRequest request, std::shared_ptr<Exchange> exchange)>;

}  // namespace caustic::service
