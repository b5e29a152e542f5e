// The head of a response as bytes.
#pragma once

#include <string>

#include "service/http/message.h"

namespace caustic::service {

/// Status line, the response's headers, Content-Type, Content-Length and Connection, the empty
/// line. A value cannot begin a line of its own: control characters in it become spaces.
std::string response_head(const HttpResponse& response, bool keep_alive);

}  // namespace caustic::service
