#include "tests/fuzz/targets.h"

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "geometry/expression/field.h"
#include "service/api/analysis_json.h"
#include "service/api/contour_json.h"
#include "service/api/irradiance_json.h"
#include "service/api/path_json.h"
#include "service/examples/examples.h"
#include "service/http/request_reader.h"
#include "tests/support/ask.h"
#include "tests/support/requests.h"
#include "tests/support/stub_engine.h"
#include "tests/support/temporary_folder.h"

namespace caustic::test {
namespace {

using nlohmann::json;
using service::HttpRequest;
using service::RequestReader;

constexpr std::size_t kMaxBody = 1u << 20;

[[noreturn]] void broken(const char* promise, std::string_view detail) {
  std::fprintf(stderr, "broken: %s: %.*s\n", promise, static_cast<int>(detail.size()),
               detail.data());
  std::abort();
}

/// Of a refusal only that it is one: which fault is seen first may depend on how much is seen.
std::string as_text(const HttpRequest& request) {
  if (request.refusal) return "refused\n";
  std::string out = request.method + ' ' + request.target + '\n';
  for (const auto& [name, value] : request.headers) out += name + ": " + value + '\n';
  return out + '\n' + request.body + (request.body_too_large ? "too large\n" : "\n");
}

/// All requests in these bytes, when they come in steps of this size.
std::string requests_in(std::string_view bytes, std::size_t step, std::size_t max_body) {
  RequestReader reader(max_body);
  std::string out;
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    reader.feed(bytes.substr(at, step));
    while (const auto request = reader.next()) {
      if (request->body.size() > max_body) broken("bodies are bounded", request->body);
      out += as_text(*request);
      if (!reader.keep_alive()) return out;
    }
    if (reader.held() > 2 * (max_body + service::kMaxHeadBytes + step) + 4096)
      broken("what is held is bounded", std::to_string(reader.held()));
  }
  return out;
}

template <typename Read>
void expect_problem_or_call(const Read& read) {
  try {
    read();
  } catch (const service::ProblemError& error) {
    const json problem = json::parse(service::to_json(error.problem()));
    if (problem["status"] != 400 && problem["status"] != 422)
      broken("bad input is 400 or 422", problem.dump());
  }
}

std::string post_of(const std::string& path, const std::string& body) {
  return "POST " + path + " HTTP/1.1\r\nHost: a\r\nContent-Type: application/json\r\n" +
         "Content-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body;
}

std::vector<std::string> body_seeds() {
  std::vector<std::string> out;
  for (const service::Example& example : service::examples())
    if (example.body.size() < 8192) out.push_back(json::parse(example.body).dump());
  for (const json& body : {path_request(), irradiance_request(), analysis_request()})
    out.push_back(body.dump());
  return out;
}

std::vector<std::string> request_seeds() {
  std::vector<std::string> out{
      "GET /healthz HTTP/1.1\r\nHost: a\r\n\r\nHEAD /openapi.json HTTP/1.0\r\n\r\n",
      "DELETE /v1/jobs/" + std::string(64, 'a') + " HTTP/1.1\r\nHost: x\r\nX-Request-Id: r\r\n\r\n",
      "GET /v1/results/" + std::string(64, 'a') +
          ".vtp HTTP/1.1\r\nHost: x\r\nIf-None-Match: W/\"x\", *\r\nAccept-Encoding: gzip;q=0.5, "
          "br\r\n\r\n",
      "POST /v1/contours HTTP/1.1\r\nHost: x\r\nContent-Type: application/json; "
      "a=b\r\nTransfer-Encoding: "
      "chunked\r\nExpect: 100-continue\r\n\r\n2;x=y\r\n{}\r\n0\r\nA: b\r\n\r\n"};
  for (const std::string& body : body_seeds()) out.push_back(post_of("/v1/contours", body));
  out.push_back(post_of("/v1/paths", path_request().dump()));
  out.push_back(post_of("/v1/irradiance", irradiance_request().dump()));
  out.push_back(post_of("/v1/analysis", analysis_request().dump()));
  return out;
}

std::vector<std::string> expression_seeds() {
  return {"x^4+y^4+z^4-x^2-y^2-z^2", "sqrt(x*x+y*y) - (1 + 0.3*sin(4*z))",
          "exp(-x^2)/(1+abs(y)) - log(z+2) ^ 3 + pi", "-x^2^3*--y/(z-1e-3)",
          "cos(x)^-2.5 - 1.5e+10"};
}

/// Everything but the engine and the time that calls about points take.
struct StubService {
  TemporaryFolder folder{"/dev/shm"};
  service::ResultStore store{folder.path(), 8u << 20};
  service::ContourService contours{draw_circles, store};
  service::Jobs jobs{{1, 16}};
  service::Routes routes{contours, store, jobs};
};

}  // namespace

void fuzz_request(std::string_view bytes) {
  for (const std::size_t max_body : {std::size_t{100}, kMaxBody}) {
    const std::string whole = requests_in(bytes, std::max<std::size_t>(1, bytes.size()), max_body);
    for (const std::size_t step : {1, 3, 64})
      if (requests_in(bytes, step, max_body) != whole) broken("cutting changes nothing", bytes);
  }
}

void fuzz_scene(std::string_view bytes) {
  expect_problem_or_call([&] { service::read_contour_call(bytes); });
  expect_problem_or_call([&] { service::read_path_call(bytes); });
  expect_problem_or_call([&] { service::read_irradiance_call(bytes); });
  expect_problem_or_call([&] { service::read_analysis_call(bytes); });
}

void fuzz_expression(std::string_view bytes) {
  geometry::Expression expression = geometry::read_expression(bytes, 1.0);
  if (!expression.fault.empty() || expression.constant()) return;
  const geometry::Field field(std::move(expression), 1.0);
  const geometry::Point x(0.3, -0.7, 1.1);
  const geometry::IntervalVec3 box = {geometry::Interval(0.2, 0.4), geometry::Interval(-0.8, -0.6),
                                      geometry::Interval(1.0, 1.2)};
  geometry::Interval range(0.0, 0.0);
  const double value = field.value(x);
  if (field.enclose(box, range) && std::isfinite(value) && !range.contains(value))
    broken("an enclosure holds the value", bytes);
}

void fuzz_service(std::string_view bytes) {
  static StubService stub;
  RequestReader reader(kMaxBody);
  reader.feed(bytes);
  while (auto request = reader.next()) {
    const bool computes = request->target.starts_with("/v1/paths") ||
                          request->target.starts_with("/v1/irradiance") ||
                          request->target.starts_with("/v1/analysis");
    if (computes && !request->refusal) {  // what they compute is another's test
      fuzz_scene(request->body);
    } else {
      const service::HttpResponse answer = ask(stub.routes, std::move(*request));
      if (answer.status == 500) broken("nothing is a 500", bytes);
      if (answer.content_type.find("json") != std::string::npos && !json::accept(answer.body))
        broken("answers are JSON", answer.body);
    }
    if (!reader.keep_alive()) return;
  }
}

const std::vector<FuzzTarget>& fuzz_targets() {
  static const std::vector<FuzzTarget> targets = {
      {"request", fuzz_request, request_seeds, 10'000},
      {"scene", fuzz_scene, body_seeds, 300},
      {"expression", fuzz_expression, expression_seeds, 2'500},
      {"service", fuzz_service, request_seeds, 10'000},
  };
  return targets;
}

}  // namespace caustic::test
