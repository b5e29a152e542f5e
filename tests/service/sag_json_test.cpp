// Height fields as a client describes them.
#include <gtest/gtest.h>

#include <map>

#include "service/api/contour_json.h"
#include "service/api/problem.h"
#include "tests/support/faults.h"
#include "tests/support/requests.h"

namespace caustic::service {
namespace {

using nlohmann::json;

json sag(const char* members) {
  json shape = json::parse(R"({"type":"sag","origin":[0,0,0],"x_axis":[1,0,0],"y_axis":[0,1,0]})");
  shape.update(json::parse(members));
  return shape;
}

json heights(std::size_t nx, std::size_t ny) {
  json shape = sag(R"({"kind":"heights","x":[-1,1],"y":[-2,2]})");
  shape["values"] = json(ny, json(nx, 0.25));
  return shape;
}

/// Pointers within the shape → details.
std::map<std::string, std::string> shape_faults(const json& shape) {
  json request = test::ball_request();
  test::surface(request)["shape"] = shape;
  return test::faults_of(request, "/scene/surfaces/0/shape");
}

std::vector<std::string> faulty_members(const json& shape) {
  return test::pointers_of(shape_faults(shape));
}

using Pointers = std::vector<std::string>;

TEST(SagJson, refuses_faulty_frames_and_kinds) {
  json shape = heights(6, 6);
  shape["y_axis"] = {-2, 0, 0};
  EXPECT_EQ(shape_faults(shape),
            (std::map<std::string, std::string>{{"/y_axis", "must not be parallel to x_axis"}}));
  EXPECT_EQ(faulty_members(sag(R"({"kind":"waves"})")), Pointers{"/kind"});
  EXPECT_EQ(faulty_members(sag("{}")), Pointers{"/kind"});
  EXPECT_EQ(faulty_members(json::parse(R"({"type":"sag"})")),
            (Pointers{"/kind", "/origin", "/x_axis", "/y_axis"}));
  EXPECT_EQ(faulty_members(sag(R"({"kind":"heights"})")), (Pointers{"/values", "/x", "/y"}));
  EXPECT_EQ(faulty_members(sag(R"({"kind":"xy_polynomial"})")), Pointers{"/terms"});
  EXPECT_EQ(faulty_members(sag(R"({"kind":"zernike"})")),
            (Pointers{"/coefficients", "/norm_radius"}));
  EXPECT_EQ(faulty_members(sag(R"({"kind":"xy_polynomial","terms":[],"norm_radius":1})")),
            Pointers{"/norm_radius"});
}

TEST(SagJson, refuses_faulty_polynomials) {
  EXPECT_EQ(faulty_members(sag(R"({"kind":"xy_polynomial","terms":[
              {"i":0,"j":-1,"c":1}, {"i":1.5,"j":0,"c":1}, {"i":11,"j":10,"c":1},
              {"i":21,"j":0,"c":1}, {"i":1,"j":1,"c":"x"}, {"i":1,"j":1}, {"i":1,"j":1,"c":1,"k":2}, 3]})")),
            (Pointers{"/terms/0/j", "/terms/1/i", "/terms/2", "/terms/3/i", "/terms/4/c",
                      "/terms/5/c", "/terms/6/k", "/terms/7"}));
  EXPECT_EQ(
      faulty_members(sag(R"({"kind":"zernike","norm_radius":0,"coefficients":{
              "-1":0, "231":0, "04":0, "1e1":0, "a/b":0, "4":null, "3":0.1}})")),
      (Pointers{"/coefficients/-1", "/coefficients/04", "/coefficients/1e1", "/coefficients/231",
                "/coefficients/4", "/coefficients/a~1b", "/norm_radius"}));
  EXPECT_EQ(faulty_members(sag(R"({"kind":"zernike","norm_radius":1,"coefficients":[0.1]})")),
            Pointers{"/coefficients"});
}

TEST(SagJson, refuses_faulty_heights) {
  EXPECT_EQ(faulty_members(heights(6, 7)), Pointers{});
  EXPECT_EQ(faulty_members(heights(5, 6)), Pointers{"/values/0"});
  EXPECT_EQ(faulty_members(heights(6, 5)), Pointers{"/values"});
  json shape = heights(8, 6);
  shape["x"] = {1, 1};
  shape["y"] = {2, -2};
  shape["values"][1].push_back(0);
  shape["values"][2] = "row";
  shape["values"][3][4] = nullptr;
  shape["values"][5][7] = 1e31;
  EXPECT_EQ(faulty_members(shape),
            (Pointers{"/values/1", "/values/2", "/values/3/4", "/values/5/7", "/x", "/y"}));
  shape = heights(6, 6);
  shape["x"] = {0, 1, 2};
  shape["values"] = 7;
  EXPECT_EQ(faulty_members(shape), (Pointers{"/values", "/x"}));
}

// Rows go along x; the frame is right-handed whatever the length and the angle of y_axis.
TEST(SagJson, puts_the_samples_where_they_belong) {
  json request = test::ball_request();
  request["scene"]["length_unit"] = "cm";
  json& shape = test::surface(request)["shape"] = heights(9, 7);
  shape["origin"] = {1, 0, 0};
  shape["x_axis"] = {0, 2, 0};
  shape["y_axis"] = {0, 5, 3};  // so y is the world's z, and z its x
  for (int j = 0; j < 7; ++j) {
    for (int i = 0; i < 9; ++i) shape["values"][j][i] = i + 10 * j;
  }
  const auto call = read_contour_call(request.dump());
  const auto& surface = *call.system.surfaces()[0].shape;
  for (int j = 0; j < 7; ++j) {
    for (int i = 0; i < 9; ++i) {
      const geometry::Point on(1.0 + i + 10 * j, -1.0 + 0.25 * i, -2.0 + 4.0 / 6.0 * j);
      EXPECT_NEAR(surface.value(0.01 * on), 0.0, 1e-14);
      EXPECT_LT(surface.value(0.01 * (on - geometry::Point(1, 0, 0))), 0.0);
    }
  }
}

}  // namespace
}  // namespace caustic::service
