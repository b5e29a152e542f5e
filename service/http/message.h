// A request and its response, free of the HTTP library.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace caustic::service {

struct HttpRequest {
  std::string method;
  std::string target;  ///< as sent, not decoded
  std::string content_type;
  std::string body;
  bool body_too_large = false;  ///< the body was longer than allowed and is not kept
};

struct HttpResponse {
  int status = 200;
  std::string content_type;
  std::string body;
  std::vector<std::pair<std::string, std::string>> headers;
};

}  // namespace caustic::service
