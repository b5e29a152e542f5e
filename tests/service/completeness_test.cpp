// What an answer says it has proven.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "service/api/answer_json.h"
#include "service/api/contour_json.h"
#include "service/examples/examples.h"
#include "tests/support/faults.h"
#include "tests/support/requests.h"

namespace caustic::service {
namespace {

using nlohmann::json;

json completeness_of(const json& request) {
  const ContourCall call = read_contour_call(request.dump());
  const auto result = solver::trace_contours(call.system, call.request);
  return json::parse(answer_json(call, result, call.id, false, ""))["completeness"];
}

json nephroid_request() { return json::parse(find_example("nephroid")->body); }

TEST(Completeness, IsProvenOnRequest) {
  json request = nephroid_request();
  request["measure"] = "sheet";
  const json fast = completeness_of(request);
  EXPECT_EQ(fast["certified"], false);
  EXPECT_EQ(fast["unproven"].size(), 1u);
  const std::string id = read_contour_call(request.dump()).id;
  request["certify"] = true;
  EXPECT_EQ(completeness_of(request), json::parse(R"({"certified":true,"undecided_cells":0})"));
  EXPECT_NE(read_contour_call(request.dump()).id, id);
}

TEST(Completeness, IsNotClaimedOfWhatRaysSeek) {
  json request = nephroid_request();
  request["measure"] = "sheet";
  request["families"] = {{"max_bounces", 2}};
  request["certify"] = true;
  const json completeness = completeness_of(request);
  EXPECT_EQ(completeness["certified"], false);
  ASSERT_FALSE(completeness["unproven"].empty());
  EXPECT_NE(completeness["unproven"][0].dump().find("sought with"), std::string::npos);
}

TEST(Completeness, IsProvenOfTheTotal) {
  json request = json::parse(find_example("plane-mirror")->body);
  request["certify"] = true;
  EXPECT_EQ(completeness_of(request), json::parse(R"({"certified":true,"undecided_cells":0})"));
  request["limits"] = {{"cells", 60}};
  const json cut = completeness_of(request);
  EXPECT_EQ(cut["certified"], false);
  ASSERT_FALSE(cut["undecided"].empty());
  for (const json& cell : cut["undecided"]) EXPECT_EQ(cell["family_id"], -1);
}

TEST(Completeness, IsNotProvenOfDirectLight) {
  json request = json::parse(find_example("plane-mirror")->body);
  request["certify"] = request["direct"] = true;
  const json completeness = completeness_of(request);
  EXPECT_EQ(completeness["certified"], false);
  EXPECT_EQ(completeness["unproven"].size(), 1u);
}

// Undecided cells come with their levels and corners, lengths in the request's unit; a limit that
// cut the proof short is no property of the request.
TEST(Completeness, ListsUndecidedCells) {
  json request = nephroid_request();
  request["measure"] = "sheet";
  request["certify"] = true;
  const std::string id = read_contour_call(request.dump()).id;
  request["limits"] = {{"cells", 60}};
  const ContourCall call = read_contour_call(request.dump());
  EXPECT_EQ(call.id, id);
  EXPECT_EQ(call.request.cell_limit, 60u);
  const auto result = solver::trace_contours(call.system, call.request);
  EXPECT_FALSE(result.complete);
  const json answer = json::parse(answer_json(call, result, call.id, false, ""));
  EXPECT_EQ(answer["complete"], false);
  const json& completeness = answer["completeness"];
  EXPECT_EQ(completeness["certified"], false);
  EXPECT_GT(completeness["undecided_cells"], 0);
  ASSERT_EQ(completeness["undecided"].size(), completeness["undecided_cells"]);
  for (const json& cell : completeness["undecided"]) {
    EXPECT_EQ(cell["family_id"], 0);
    EXPECT_FALSE(cell["levels"].empty());
    ASSERT_EQ(cell["corners"].size(), 4u);
    for (const json& corner : cell["corners"]) {
      ASSERT_EQ(corner.size(), 3u);
      for (const json& x : corner) EXPECT_LT(std::abs(x.get<double>()), 2.0);
    }
  }
}

TEST(Completeness, LimitsOfCellsAreChecked) {
  json request = nephroid_request();
  request["limits"] = {{"cells", 0}};
  EXPECT_EQ(test::pointers_of(request), std::vector<std::string>{"/limits/cells"});
}

}  // namespace
}  // namespace caustic::service
