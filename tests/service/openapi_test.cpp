// openapi.json says what is served: routes, members, shapes, formats.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "service/examples/examples.h"
#include "service/formats/format.h"
#include "service/http/routes.h"
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

TEST(Openapi, certified_answers_fit_it) {
  const test::TemporaryFolder folder;
  const ResultStore store(folder.path());
  const ContourService contours(solver::trace_contours, store);
  json request = json::parse(find_example("nephroid")->body);
  request["certify"] = true;
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

TEST(Openapi, every_path_is_served_and_every_format_is_there) {
  const test::TemporaryFolder folder;
  const ResultStore store(folder.path());
  const ContourService contours(test::draw_circles, store);
  Jobs jobs({1, 4});
  Routes routes(contours, store, jobs);
  const json answer = json::parse(contours.post(test::ball_request().dump()));
  for (const auto& [path, methods] : document()["paths"].items()) {
    std::string target = path;
    if (const auto at = target.find("{id}"); at != target.npos) target.replace(at, 4, answer["id"]);
    if (const auto at = target.find("{name}"); at != target.npos)
      target.replace(at, 6, examples()[0].name);
    for (const auto& [method, operation] : methods.items()) {
      const bool is_post = method == "post";
      const auto response = test::ask(routes, {is_post ? "POST" : "GET", target, "application/json",
                                               is_post ? body_for(path).dump() : "", false});
      EXPECT_EQ(response.status, 200) << path;
      EXPECT_TRUE(operation["responses"]["200"]["content"].contains(response.content_type)) << path;
    }
  }
  for (const Format& format : formats())
    EXPECT_TRUE(document()["paths"].contains(std::string("/v1/results/{id}.") + format.suffix));
}

}  // namespace
}  // namespace caustic::service
