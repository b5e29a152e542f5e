#include "service/api/problem.h"

#include <nlohmann/json.hpp>

#include "service/api/json_text.h"

namespace caustic::service {
namespace {

const char* title_of(int status) {
  switch (status) {
    case 400:
      return "Bad Request";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 413:
      return "Content Too Large";
    case 414:
      return "URI Too Long";
    case 415:
      return "Unsupported Media Type";
    case 422:
      return "Unprocessable Content";
    case 503:
      return "Service Unavailable";
    case 507:
      return "Insufficient Storage";
    default:
      return "Internal Server Error";
  }
}

}  // namespace

Problem make_problem(int status, std::string detail, std::vector<Fault> errors) {
  return {status, title_of(status), std::move(detail), std::move(errors)};
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
