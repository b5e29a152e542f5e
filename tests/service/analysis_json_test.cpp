// POST /v1/analysis, from body to answer.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "service/api/problem.h"
#include "service/point_service.h"
#include "tests/support/requests.h"

namespace caustic::service {
namespace {

using nlohmann::json;
using test::analysis_request;

json analysis(const json& request) { return json::parse(answer_analysis(request.dump())); }

std::vector<std::string> pointers_of_faults(const json& request) {
  std::vector<std::string> pointers;
  try {
    answer_analysis(request.dump());
    ADD_FAILURE() << "no fault found";
  } catch (const ProblemError& error) {
    EXPECT_EQ(error.problem().status, 422);
    for (const Fault& fault : error.problem().errors) pointers.push_back(fault.pointer);
  }
  return pointers;
}
using Pointers = std::vector<std::string>;

TEST(AnalysisCall, lengths_have_units_and_light_has_none) {
  const json metres = analysis(analysis_request());
  ASSERT_EQ(metres["levels"].size(), 2u);
  EXPECT_EQ(metres["levels"][0]["level"], 0.0003);
  EXPECT_EQ(metres["completeness"]["undecided_cells"], 0);
  json request = analysis_request();
  json& scene = request["scene"];
  scene["length_unit"] = "cm";
  scene["light"]["position"] = {30, 20, 400};
  scene["surfaces"][0]["shape"]["radius"] = 100;
  scene["receiver"]["origin"] = {0, 0, 600};
  scene["receiver"]["size"] = {1200, 1200};
  const json centimetres = analysis(request);
  const auto value = [](const json& of) { return of["value"].get<double>(); };
  EXPECT_NEAR(value(metres["flux"]), value(centimetres["flux"]), 1e-10);
  EXPECT_NEAR(value(metres["E_avg"]), value(metres["flux"]) / 144.0, 1e-15);
  EXPECT_NEAR(value(metres["E_avg"]), value(centimetres["E_avg"]), 1e-12);
  EXPECT_NEAR(value(metres["E_max"]), value(centimetres["E_max"]), 1e-12);
  EXPECT_EQ(metres["E_max"]["unbounded"], false);
  EXPECT_NEAR(100 * metres["E_max"]["uv"][0].get<double>(), centimetres["E_max"]["uv"][0], 1e-3);
  EXPECT_NEAR(metres["U0"].get<double>(), value(metres["E_min"]) / value(metres["E_avg"]), 1e-12);
  EXPECT_NEAR(metres["Ud"].get<double>(), value(metres["E_min"]) / value(metres["E_max"]), 1e-12);
  for (const int i : {0, 1}) {
    const json &m = metres["levels"][i], &cm = centimetres["levels"][i];
    EXPECT_NEAR(1e4 * value(m["area"]), value(cm["area"]), 1e-3);
    EXPECT_NEAR(value(m["flux"]), value(cm["flux"]), 1e-10);
    EXPECT_GT(m["area"]["error"].get<double>(), 0.0);
  }
}

TEST(AnalysisCall, is_unbounded_on_a_caustic) {
  json request = analysis_request();
  json& scene = request["scene"];
  scene["light"] = {{"type", "collimated"}, {"direction", {1, 0, -1}}, {"irradiance", 1}};
  scene["surfaces"][0]["shape"] = {
      {"type", "cylinder"}, {"point", {0, 0, 0}}, {"axis", {0, 0, 1}}, {"radius", 1}};
  scene["surfaces"][0]["aperture"] = {
      {{"type", "box"}, {"min", {0.5, -1, 0}}, {"max", {1.001, 1, 1}}}};
  scene["receiver"]["origin"] = {0.5, 0, 0};
  scene["receiver"]["size"] = {1.2, 1.2};
  request["levels"] = {2};
  const json answer = analysis(request);
  EXPECT_EQ(answer["E_max"]["value"], nullptr);
  EXPECT_EQ(answer["E_max"]["unbounded"], true);
  EXPECT_EQ(answer["E_min"]["value"], 0.0);
  EXPECT_EQ(answer["U0"], 0.0);
  EXPECT_EQ(answer["Ud"], 0.0);
}

TEST(AnalysisCall, chooses_levels_that_are_not_given) {
  json request = analysis_request();
  request["levels"] = {{"count", 3}, {"spacing", "linear"}};
  EXPECT_EQ(analysis(request)["levels"].size(), 3u);
  request.erase("levels");
  EXPECT_EQ(analysis(request)["levels"].size(), 8u);
}

TEST(AnalysisCall, names_every_fault) {
  json request = analysis_request();
  request["families"] = {{"nobody"}};
  request["levels"] = {0.1, -1, "two"};
  request["direct"] = 1;
  request["measure"] = "total";
  test::surface(request)["shape"]["radius"] = -1;
  EXPECT_EQ(pointers_of_faults(request),
            (Pointers{"/scene/surfaces/0/shape/radius", "/families/0/0", "/levels/1", "/levels/2",
                      "/direct", "/measure"}));
  EXPECT_EQ(pointers_of_faults(json::object()), Pointers{"/scene"});
}

TEST(AnalysisCall, says_what_this_version_lacks) {
  json request = analysis_request();
  json& scene = request["scene"];
  scene["light"]["position"] = {0, 0, -0.6};  // in one focus
  scene["surfaces"][0]["shape"] = {
      {"type", "ellipsoid"}, {"center", {0, 0, 0}}, {"semi_axes", {0.8, 0.8, 1}}};
  scene["surfaces"][0]["aperture"] = {
      {{"type", "box"}, {"min", {-1, -1, -1}}, {"max", {1, 1, 0.3}}}};
  scene["receiver"]["origin"] = {0, 0, 0.6};
  scene["receiver"]["size"] = {0.4, 0.4};
  EXPECT_EQ(pointers_of_faults(request), Pointers{"/scene"});
}

TEST(AnalysisCall, stops_when_the_service_does) {
  const std::atomic<bool> stopping = true;
  try {
    answer_analysis(analysis_request().dump(), &stopping);
    ADD_FAILURE() << "was answered";
  } catch (const ProblemError& error) {
    EXPECT_EQ(error.problem().status, 503);
  }
}

}  // namespace
}  // namespace caustic::service
