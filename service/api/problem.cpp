#include "service/api/problem.h"

#include <iostream>
#include <nlohmann/json.hpp>

#include "service/api/json_text.h"

namespace caustic::service {

const char* title_of_status(int status) {
  switch (status) {
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 408:
      return "Request Timeout";
    case 409:
      return "Conflict";
    case 413:
      return "Content Too Large";
    case 414:
      return "URI Too Long";
    case 415:
      return "Unsupported Media Type";
    case 416:
      return "Range Not Satisfiable";
    case 417:
      return "Expectation Failed";
    case 422:
      return "Unprocessable Content";
    case 431:
      return "Request Header Fields Too Large";
    case 503:
      return "Service Unavailable";
    case 505:
      return "HTTP Version Not Supported";
    case 507:
      return "Insufficient Storage";
    default:
      return "Internal Server Error";
  }
}

Problem make_problem(int status, std::string detail, std::vector<Fault> errors) {
  return {status, title_of_status(status), std::move(detail), std::move(errors)};
}

Problem report_bug(const char* what) {
  std::cerr << "internal error: " << what << std::endl;
  return make_problem(500, "internal error");
}

std::string to_json(const Problem& problem) {
  nlohmann::ordered_json document{{"type", "about:blank"},
                                  {"title", problem.title},
                                  {"status", problem.status},
                                  {"detail", problem.detail}};
  auto& errors = document["errors"] = nlohmann::ordered_json::array();
  for (const Fault& fault : problem.errors)
    errors.push_back({{"pointer", fault.pointer}, {"detail", fault.detail}});
  return write_json(document);
}

}  // namespace caustic::service
