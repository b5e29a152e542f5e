#include "service/http/routes.h"

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "service/api/identity.h"
#include "service/api/json_text.h"
#include "service/api/problem.h"
#include "service/examples/examples.h"
#include "service/formats/format.h"
#include "service/point_service.h"

namespace caustic::service {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMaxTarget = 1000;

[[noreturn]] void refuse(int status, std::string detail) {
  throw ProblemError(make_problem(status, std::move(detail)));
}

HttpResponse json_response(std::string body) {
  return {200, "application/json", std::move(body), {}};
}

/// `application/json`, with parameters or without.
bool is_json(std::string type) {
  type.resize(std::min(type.size(), type.find(';')));
  while (!type.empty() && (type.back() == ' ' || type.back() == '\t')) type.pop_back();
  std::transform(type.begin(), type.end(), type.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return type == "application/json";
}

/// True if `path` is the pattern, whose last step may be {}: any one step, returned in `name`.
bool matches(std::string_view pattern, std::string_view path, std::string& name) {
  if (!pattern.ends_with("{}")) return path == pattern;
  pattern.remove_suffix(2);
  if (!path.starts_with(pattern)) return false;
  path.remove_prefix(pattern.size());
  name = path;
  return !path.empty() && path.find('/') == path.npos;
}

bool method_fits(std::string_view served, std::string_view asked) {
  return served == asked || (served == "GET" && asked == "HEAD");
}

HttpResponse internal_error(const char* what) {
  std::cerr << "internal error: " << what << std::endl;
  return problem_response(make_problem(500, "internal error"));
}

}  // namespace

struct Routes::Row {
  const char* method;
  const char* pattern;
  bool takes_json;
  HttpResponse (Routes::*handler)(const HttpRequest&, const std::string&) const;
};

// clang-format off
const Routes::Row Routes::kTable[] = {
    {"POST", "/v1/contours",    true,  &Routes::post_contours},
    {"POST", "/v1/paths",       true,  &Routes::post_paths},
    {"POST", "/v1/irradiance",  true,  &Routes::post_irradiance},
    {"POST", "/v1/analysis",    true,  &Routes::post_analysis},
    {"GET",  "/v1/results/{}",  false, &Routes::get_result},
    {"GET",  "/v1/examples",    false, &Routes::list_examples},
    {"GET",  "/v1/examples/{}", false, &Routes::get_example},
    {"GET",  "/healthz",        false, &Routes::health},
    {"GET",  "/openapi.json",   false, &Routes::openapi},
};
// clang-format on

HttpResponse problem_response(const Problem& problem) {
  return {problem.status, "application/problem+json", to_json(problem), {}};
}

HttpResponse Routes::answer(const HttpRequest& request) const noexcept {
  try {
    return dispatch(request);
  } catch (const ProblemError& error) {
    return problem_response(error.problem());
  } catch (const std::exception& error) {
    return internal_error(error.what());
  } catch (...) {
    return internal_error("of no known type");
  }
}

HttpResponse Routes::dispatch(const HttpRequest& request) const {
  if (request.target.size() > kMaxTarget) refuse(414, "the path is too long");
  const std::string path = request.target.substr(0, request.target.find('?'));
  std::string allowed;
  for (const Row& row : kTable) {
    std::string name;
    if (!matches(row.pattern, path, name)) continue;
    if (!method_fits(row.method, request.method)) {
      allowed = row.method;
      continue;
    }
    if (row.takes_json && !is_json(request.content_type))
      refuse(415, "Content-Type must be application/json");
    if (row.takes_json && request.body_too_large) refuse(413, "the body is too large");
    return (this->*row.handler)(request, name);
  }
  if (allowed.empty()) refuse(404, "nothing is here");
  if (allowed == "GET") allowed = "GET, HEAD";
  HttpResponse response = problem_response(make_problem(405, "this path takes " + allowed));
  response.headers.emplace_back("Allow", allowed);
  return response;
}

HttpResponse Routes::post_contours(const HttpRequest& request, const std::string&) const {
  return json_response(contours_.post(request.body));
}

HttpResponse Routes::post_paths(const HttpRequest& request, const std::string&) const {
  return json_response(answer_paths(request.body, stopping_));
}

HttpResponse Routes::post_irradiance(const HttpRequest& request, const std::string&) const {
  return json_response(answer_irradiance(request.body, stopping_));
}

HttpResponse Routes::post_analysis(const HttpRequest& request, const std::string&) const {
  return json_response(answer_analysis(request.body, stopping_));
}

/// `<id>` is the answer, `<id>.<suffix>` a file.
HttpResponse Routes::get_result(const HttpRequest&, const std::string& name) const {
  const std::string id = name.substr(0, name.find('.'));
  if (!is_id(id)) refuse(404, "no such result");
  if (name == id) {
    const auto answer = store_.load_answer(id);
    if (!answer) refuse(404, "no such result");
    return json_response(*answer);
  }
  const Format* format = find_format(std::string_view(name).substr(id.size() + 1));
  if (!format) refuse(404, "no such format");
  const auto record = store_.load(id);
  if (!record) refuse(404, "no such result");
  return {200,
          format->media_type,
          format->write(record->curves),
          {{"Content-Disposition", "attachment; filename=" + name}}};
}

HttpResponse Routes::list_examples(const HttpRequest&, const std::string&) const {
  auto list = ordered_json::array();
  for (const Example& example : examples())
    list.push_back({{"name", example.name}, {"title", example.title}});
  return json_response(write_json(ordered_json{{"examples", list}}));
}

HttpResponse Routes::get_example(const HttpRequest&, const std::string& name) const {
  const Example* example = find_example(name);
  if (!example) refuse(404, "no such example");
  return json_response(std::string(example->body));
}

HttpResponse Routes::health(const HttpRequest&, const std::string&) const {
  return json_response(write_json(ordered_json{{"status", "ok"}, {"version", kEngineVersion}}));
}

HttpResponse Routes::openapi(const HttpRequest&, const std::string&) const {
  return json_response(std::string(openapi_document()));
}

}  // namespace caustic::service
