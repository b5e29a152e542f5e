#include "service/http/response_head.h"

#include <algorithm>

namespace caustic::service {
namespace {

const char* phrase_of(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 202:
      return "Accepted";
    case 204:
      return "No Content";
    case 304:
      return "Not Modified";
    default:
      return title_of_status(status);
  }
}

void add_line(std::string& out, std::string_view name, std::string_view value) {
  out.append(name).append(": ");
  for (const char c : value) out += static_cast<unsigned char>(c) < ' ' || c == '\x7f' ? ' ' : c;
  out += "\r\n";
}

}  // namespace

std::string response_head(const HttpResponse& response, bool keep_alive) {
  std::string out =
      "HTTP/1.1 " + std::to_string(response.status) + ' ' + phrase_of(response.status) + "\r\n";
  for (const auto& [name, value] : response.headers) add_line(out, name, value);
  if (!response.content_type.empty()) add_line(out, "Content-Type", response.content_type);
  const bool has_length = !response.events && response.status != 204 && response.status != 304;
  if (has_length) add_line(out, "Content-Length", std::to_string(response.body.size()));
  add_line(out, "Connection", keep_alive ? "keep-alive" : "close");
  return out += "\r\n";
}

}  // namespace caustic::service
