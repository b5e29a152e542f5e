// openapi.json says what is served: routes, members, shapes, formats.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "service/examples/examples.h"
#include "service/formats/format.h"
#include "service/http/docs_page.h"
#include "service/http/routes.h"
#include "service/page/page_files.h"
#include "service/point_service.h"
#include "tests/support/ask.h"
#include "tests/support/requests.h"
#include "tests/support/stub_engine.h"
#include "tests/support/temporary_folder.h"

namespace caustic::service {
namespace {

using nlohmann::json;

const json& document() {
  static const json parsed = json::parse(openapi_document());
  return parsed;
}

/// A small part of JSON Schema: what the document uses.
bool valid(const json& schema, const json& value, std::string& why);

const json& resolved(const json& schema) {
  if (!schema.contains("$ref")) return schema;
  return document()[json::json_pointer(schema["$ref"].get<std::string>().substr(1))];
}

bool type_fits(const json& type, const json& value) {
  if (type.is_array())
    return std::any_of(type.begin(), type.end(),
                       [&](const json& t) { return type_fits(t, value); });
  if (type == "integer")
    return value.is_number() && value.get<double>() == std::floor(value.get<double>());
  if (type == "null") return value.is_null();
  return (type == "object" && value.is_object()) || (type == "array" && value.is_array()) ||
         (type == "string" && value.is_string()) || (type == "boolean" && value.is_boolean()) ||
         (type == "number" && value.is_number());
}

bool object_fits(const json& schema, const json& value, std::string& why) {
  for (const json& key : schema.value("required", json::array()))
    if (!value.contains(key)) return why = "missing " + key.dump(), false;
  for (const auto& [key, member] : value.items()) {
    if (!schema.contains("properties")) continue;
    if (!schema["properties"].contains(key)) return why = "unknown " + key, false;
    if (!valid(schema["properties"][key], member, why)) return why = key + ": " + why, false;
  }
  return true;
}

bool valid(const json& unresolved, const json& value, std::string& why) {
  const json& schema = resolved(unresolved);
  why = value.dump().substr(0, 200);
  if (schema.contains("oneOf"))
    return 1 == std::count_if(schema["oneOf"].begin(), schema["oneOf"].end(), [&](const json& one) {
             std::string reason;
             return valid(one, value, reason);
           });
  if (schema.contains("const")) return schema["const"] == value;
  if (schema.contains("enum"))
    return std::find(schema["enum"].begin(), schema["enum"].end(), value) != schema["enum"].end();
  if (schema.contains("type") && !type_fits(schema["type"], value)) return false;
  if (value.is_array() && schema.contains("items")) {
    if (value.size() < schema.value("minItems", 0u) ||
        value.size() > schema.value("maxItems", 1u << 20))
      return false;
    for (const json& element : value)
      if (!valid(schema["items"], element, why)) return false;
  }
  return !value.is_object() || object_fits(schema, value, why);
}

void expect_valid(const char* schema, const json& value) {
  std::string why;
  EXPECT_TRUE(valid(document()["components"]["schemas"][schema], value, why))
      << schema << ": " << why;
}

TEST(Openapi, examples_fit_it) {
  for (const Example& example : examples())
    expect_valid("ContourRequest", json::parse(example.body));
}

TEST(Openapi, answers_fit_it) {
  const test::TemporaryFolder folder;
  const ResultStore store(folder.path());
  const ContourService contours(test::draw_circles, store);
  Jobs jobs({1, 4});
  Routes routes(contours, store, jobs);
  json request = test::ball_request();
  for (const bool stored : {true, false}) {
    request["store"] = stored;
    expect_valid("ContourAnswer", json::parse(contours.post(request.dump())));
  }
  const auto bad = test::ask(routes, {"POST", "/v1/contours", "application/json", "{}", false});
  expect_valid("Problem", json::parse(bad.body));
}

TEST(Openapi, everything_included_fits_it) {
  const test::TemporaryFolder folder;
  const ResultStore store(folder.path());
  const ContourService contours(solver::trace_contours, store);
  json request = json::parse(find_example("nephroid")->body);
  request["scene"]["length_unit"] = "mm";  // all of it a thousandth as large
  request["include"] = {"isolux", "caustic", "boundaries", "critical_points", "regions"};
  expect_valid("ContourRequest", request);
  json answer = json::parse(contours.post(request.dump()));
  expect_valid("ContourAnswer", answer);
  EXPECT_FALSE(answer["regions"].empty());
  for (const json& region : answer["regions"])
    EXPECT_LT(std::abs(region["uv_inside"][0].get<double>()), 2.0);
  request["measure"] = "sheet";
  request["include"] = {"critical_points"};
  answer = json::parse(contours.post(request.dump()));
  expect_valid("ContourAnswer", answer);
  EXPECT_TRUE(answer.contains("critical_points"));
  EXPECT_TRUE(answer["curves"].empty());
  EXPECT_FALSE(answer.contains("regions"));
}

TEST(Openapi, certified_answers_fit_it) {
  const test::TemporaryFolder folder;
  const ResultStore store(folder.path());
  const ContourService contours(solver::trace_contours, store);
  json request = json::parse(find_example("nephroid")->body);
  request["certify"] = true;
  request["measure"] = "sheet";
  for (const int cells : {60, 10000}) {
    request["limits"] = {{"cells", cells}};
    expect_valid("ContourRequest", request);
    const json answer = json::parse(contours.post(request.dump()));
    expect_valid("ContourAnswer", answer);
    EXPECT_EQ(answer["completeness"].contains("undecided"), cells == 60);
  }
}

TEST(Openapi, answers_of_totals_fit_it) {
  const test::TemporaryFolder folder;
  const ResultStore store(folder.path());
  const ContourService contours(solver::trace_contours, store);
  json request = test::ball_request();
  request["measure"] = "total";
  request["levels"] = {0.00018, 0.0005};
  expect_valid("ContourRequest", request);
  const json answer = json::parse(contours.post(request.dump()));
  expect_valid("ContourAnswer", answer);
  int edges = 0;
  for (const json& curve : answer["curves"]) edges += curve["kind"] == "receiver_edge";
  EXPECT_GT(edges, 0);
}

TEST(Openapi, calls_about_points_fit_it) {
  expect_valid("PathRequest", test::path_request());
  expect_valid("PathAnswer", json::parse(answer_paths(test::path_request().dump())));
  expect_valid("IrradianceRequest", test::irradiance_request());
  expect_valid("IrradianceAnswer",
               json::parse(answer_irradiance(test::irradiance_request().dump())));
  expect_valid("AnalysisRequest", test::analysis_request());
  expect_valid("AnalysisAnswer", json::parse(answer_analysis(test::analysis_request().dump())));
}

/// A body that the path takes.
json body_for(const std::string& path) {
  if (path == "/v1/paths") return test::path_request();
  if (path == "/v1/irradiance") return test::irradiance_request();
  if (path == "/v1/analysis") return test::analysis_request();
  return test::ball_request();
}

/// A service with a stored result and jobs that have ended.
class OpenapiService : public testing::Test {
 protected:
  HttpResponse ask(const std::string& method, const std::string& target,
                   const std::string& body = "", HttpHeaders headers = {}) {
    HttpRequest request{method, target, "application/json", body, false};
    request.headers = std::move(headers);
    return test::ask(routes, std::move(request));
  }
  /// The answer is documented: its status, its media type, and its body if it is JSON.
  void expect_documented(const std::string& path, const std::string& method,
                         const HttpResponse& response) {
    const json& operation = document()["paths"][path][method];
    const std::string status = std::to_string(response.status), where = method + " " + path;
    ASSERT_TRUE(operation["responses"].contains(status)) << where << ' ' << status;
    const json& documented = operation["responses"][status];
    EXPECT_EQ(documented.contains("content"), !response.content_type.empty()) << where;
    if (response.content_type.empty()) return;
    ASSERT_TRUE(documented["content"].contains(response.content_type))
        << where << ' ' << response.content_type;
    const json& schema = documented["content"][response.content_type]["schema"];
    std::string why;
    if (response.content_type.find("json") == std::string::npos) return;
    EXPECT_TRUE(valid(schema, json::parse(response.body), why)) << where << ": " << why;
  }
  std::string filled(std::string path) {
    const bool is_job = path.starts_with("/v1/jobs/");
    if (const auto at = path.find("{id}"); at != path.npos)
      path.replace(at, 4, is_job ? job : answer["id"].get<std::string>());
    if (const auto at = path.find("{name}"); at != path.npos)
      path.replace(at, 6, examples()[0].name);
    for (const PageFile& file : page_files())
      if (path == "/assets/{file}" && file.path.starts_with("/assets/"))
        return std::string(file.path);
    return path;
  }
  /// In a build without the page.
  static bool is_left_out(const std::string& path) {
    return page_files().empty() && (path == "/" || path.starts_with("/assets/"));
  }
  static std::string upper(std::string method) {
    for (char& c : method) c = static_cast<char>(std::toupper(c));
    return method;
  }

  test::TemporaryFolder folder;
  ResultStore store{folder.path()};
  ContourService contours{test::draw_circles, store};
  Jobs jobs{{1, 4}};
  Routes routes{contours, store, jobs};
  json answer = json::parse(contours.post(test::ball_request().dump()));
  std::string job = [this] {
    json request = test::ball_request();
    request["levels"] = {0.0007};
    const HttpResponse response =
        ask("POST", "/v1/contours", request.dump(), {{"prefer", "wait=1, respond-async"}});
    EXPECT_EQ(response.status, 202);
    expect_documented("/v1/contours", "post", response);
    return json::parse(response.body)["id"].get<std::string>();
  }();
};

TEST_F(OpenapiService, every_path_is_served_and_every_format_is_there) {
  for (const auto& [path, methods] : document()["paths"].items())
    for (const auto& [method, operation] : methods.items()) {
      const HttpResponse response =
          ask(upper(method), filled(path), method == "post" ? body_for(path).dump() : "");
      EXPECT_EQ(response.status, is_left_out(path) ? 404 : 200) << method << ' ' << path;
      expect_documented(path, method, response);
    }
  for (const Format& format : formats())
    EXPECT_TRUE(document()["paths"].contains(std::string("/v1/results/{id}.") + format.suffix));
}

TEST_F(OpenapiService, the_page_without_scripts_shows_all_of_it) {
  const std::string page = docs_page(openapi_document());
  for (const auto& [path, methods] : document()["paths"].items())
    for (const auto& [method, operation] : methods.items()) {
      EXPECT_NE(page.find("<code>" + upper(method) + ' ' + path + "</code>"), std::string::npos);
    }
  // Every link within the page leads somewhere.
  for (auto at = page.find("href=\"#"); at != std::string::npos;
       at = page.find("href=\"#", at + 1)) {
    const auto begin = at + 7, end = page.find('"', begin);
    EXPECT_NE(page.find("id=\"" + page.substr(begin, end - begin) + '"'), std::string::npos);
  }
  EXPECT_EQ(page.find("<script"), std::string::npos);
}

TEST_F(OpenapiService, every_route_is_documented) {
  for (auto [method, pattern] : Routes::all()) {
    for (char& c : method) c = static_cast<char>(std::tolower(c));
    bool found = false;
    for (const auto& [path, methods] : document()["paths"].items()) {
      const auto begin = path.find('{'), end = path.find('}');
      const std::string plain =
          begin == path.npos ? path : path.substr(0, begin) + "{}" + path.substr(end + 1);
      found = found || (plain == pattern && methods.contains(method));
    }
    EXPECT_TRUE(found) << method << ' ' << pattern;
  }
}

TEST_F(OpenapiService, errors_are_documented) {
  for (const auto& [path, methods] : document()["paths"].items())
    for (const auto& [method, operation] : methods.items()) {
      if (method == "post") {
        for (const char* body : {"", "{", "{}", "[]", "{\"scene\": 1e999}"})
          expect_documented(path, method, ask("POST", path, body));
        expect_documented(path, method, test::ask(routes, {"POST", path, "text/plain", "", false}));
        expect_documented(path, method,
                          test::ask(routes, {"POST", path, "application/json", "", true}));
      } else if (path.find('{') != path.npos) {
        std::string absent = filled(path);
        if (absent.find("examples") != absent.npos)
          absent = "/v1/examples/none";
        else if (absent.starts_with("/assets/"))
          absent = "/assets/none.js";
        else
          absent.replace(path.find('{'), 64, std::string(64, '0'));
        const HttpResponse response = ask(upper(method), absent);
        EXPECT_EQ(response.status, 404);
        expect_documented(path, method, response);
      }
    }
  expect_documented("/v1/jobs/{id}/events", "get",
                    ask("GET", "/v1/jobs/" + job + "/events", "", {{"last-event-id", "end"}}));
  expect_documented("/v1/results/{id}", "get",
                    ask("GET", filled("/v1/results/{id}"), "", {{"if-none-match", "*"}}));
  for (const PageFile& file : page_files()) {
    const std::string path =
        file.path.starts_with("/assets/") ? "/assets/{file}" : std::string(file.path);
    expect_documented(path, "get",
                      ask("GET", std::string(file.path), "", {{"if-none-match", "*"}}));
  }
  jobs.interrupt();
  json other = test::ball_request();
  other["levels"] = {0.0008};
  for (const char* path : {"/v1/contours", "/v1/paths", "/v1/irradiance", "/v1/analysis"}) {
    const auto response = ask(
        "POST", path, path == std::string("/v1/contours") ? other.dump() : body_for(path).dump());
    EXPECT_EQ(response.status, 503);
    expect_documented(path, "post", response);
  }
}

}  // namespace
}  // namespace caustic::service
