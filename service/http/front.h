// What every answer has in common, whichever route it comes from: who may ask, from which pages,
// the request's id, counts and the log.
#pragma once

#include <string>
#include <vector>

#include "service/http/message.h"
#include "service/log_lines.h"
#include "service/metrics.h"

namespace caustic::service {

struct FrontOptions {
  std::vector<std::string> origins;  ///< of pages elsewhere that may read answers
  std::string token;                 ///< that clients must show; empty: none
};

class Front {
 public:
  /// `log` may be null.
  Front(HttpHandler routes, const FrontOptions& options, Metrics& metrics, LogLines* log);

  void operator()(HttpRequest request, std::shared_ptr<Exchange> exchange) const;

 private:
  class Answering;

  bool may_ask(const HttpRequest& request) const;
  bool asks_for_methods(const HttpRequest& request) const;
  HttpResponse methods(const HttpRequest& request) const;
  bool is_friend(std::string_view origin) const;

  HttpHandler routes_;
  FrontOptions options_;
  std::string token_digest_;
  Metrics& metrics_;
  LogLines* log_;
};

}  // namespace caustic::service
