#include "service/api/contour_json.h"

#include <gtest/gtest.h>

#include "service/api/identity.h"
#include "service/api/problem.h"
#include "tests/support/faults.h"
#include "tests/support/requests.h"

namespace caustic::service {
namespace {

using nlohmann::json;
using test::ball_request;
using test::pointers_of;

std::string id_of(const json& request) { return read_contour_call(request.dump()).id; }

using Pointers = std::vector<std::string>;

TEST(ContourJson, reads_the_measure) {
  json request = ball_request();
  const ContourCall either = read_contour_call(request.dump());
  EXPECT_EQ(either.request.measure, solver::Measure::total);
  EXPECT_TRUE(either.request.sheets_instead);
  request["measure"] = "total";
  const ContourCall total = read_contour_call(request.dump());
  EXPECT_EQ(total.request.measure, solver::Measure::total);
  EXPECT_FALSE(total.request.sheets_instead);
  EXPECT_NE(total.id, either.id);
  request["measure"] = "sheet";
  const ContourCall sheet = read_contour_call(request.dump());
  EXPECT_EQ(sheet.request.measure, solver::Measure::sheet);
  EXPECT_NE(sheet.id, either.id);
}

TEST(ContourJson, fills_the_defaults_in) {
  json request = ball_request();
  request.erase("levels");
  const ContourCall call = read_contour_call(request.dump());
  EXPECT_TRUE(call.request.families.empty());
  EXPECT_EQ(call.request.levels.count, 8);
  EXPECT_EQ(call.request.levels.spacing, solver::LevelRequest::Spacing::log);
  EXPECT_FALSE(call.request.levels.min || call.request.levels.max);
  EXPECT_TRUE(call.request.isolux && call.request.caustic && call.store);
  EXPECT_DOUBLE_EQ(call.request.irradiance_tolerance, 1e-9);
  EXPECT_DOUBLE_EQ(call.request.chord_tolerance, 0.0012);
  EXPECT_DOUBLE_EQ(call.request.time_limit, 5.0);
  EXPECT_EQ(call.request.vertex_limit, 500'000u);
  EXPECT_EQ(
      call.scene_json,
      R"({"length_unit":"m","light":{"intensity":1,"position":[0.3,0.2,4],"type":"point"},)"
      R"("quantity":"radiometric","receiver":{"origin":[0,0,6],"size":[12,12],"type":"plane",)"
      R"("u_axis":[1,0,0],"v_axis":[0,1,0]},"surfaces":[{"aperture":[],"name":"ball",)"
      R"("optics":{"reflectance":1,"type":"mirror"},"pose":{"rotate":{"axis":[0,0,1],)"
      R"("degrees":0},"translate":[0,0,0]},"shape":{"center":[0,0,0],"radius":1,)"
      R"("type":"sphere"}}]})");
}

TEST(ContourJson, boundaries_and_regions_come_with_the_total) {
  json request = ball_request();
  request["include"] = {"boundaries", "regions"};
  const ContourCall call = read_contour_call(request.dump());
  EXPECT_TRUE(call.request.boundaries && call.request.regions);
  EXPECT_FALSE(call.request.isolux || call.request.caustic || call.request.critical_points);
  request["measure"] = "sheet";
  EXPECT_EQ(pointers_of(request), (Pointers{"/include/0", "/include/1"}));
  request["include"] = {"critical_points"};
  EXPECT_TRUE(read_contour_call(request.dump()).request.critical_points);
  request["include"] = {"points"};
  EXPECT_EQ(pointers_of(request), Pointers{"/include/0"});
}

TEST(ContourJson, the_direct_light_belongs_to_the_total) {
  json request = ball_request();
  EXPECT_FALSE(read_contour_call(request.dump()).request.direct);
  request["direct"] = true;
  const ContourCall call = read_contour_call(request.dump());
  EXPECT_TRUE(call.request.direct);
  EXPECT_EQ(call.request.measure, solver::Measure::total);
  EXPECT_FALSE(call.request.sheets_instead);
  EXPECT_NE(call.id, id_of(ball_request()));
  request["measure"] = "sheet";
  EXPECT_EQ(pointers_of(request), Pointers{"/direct"});
  request["direct"] = 1;
  EXPECT_EQ(pointers_of(request), Pointers{"/direct"});
}

TEST(ContourJson, identity_is_what_is_asked_not_how) {
  const json plain = ball_request();
  const std::string id = id_of(plain);
  json same = plain;
  same["families"] = {{"max_bounces", 1}};
  same["include"] = {"isolux", "caustic", "isolux"};
  same["direct"] = same["certify"] = false;
  same["tolerance"] = {{"chord", 1e-4 * 12}};
  same["scene"]["length_unit"] = "m";
  same["scene"]["light"]["intensity"] = 1.0;
  same["scene"]["light"]["position"][0] = 3e-1;
  same["scene"]["receiver"]["origin"][0] = -0.0;
  same["limits"] = {{"time_ms", 100}, {"cells", 1000}};
  same["store"] = false;
  EXPECT_EQ(id_of(same), id);
  EXPECT_EQ(read_contour_call(plain.dump(4)).id, id);

  // Members in the opposite order.
  std::string reversed = "{";
  for (auto member = plain.rbegin(); member != plain.rend(); ++member)
    reversed += (reversed.size() > 1 ? "," : "") + json(member.key()).dump() + ":" + member->dump();
  EXPECT_EQ(read_contour_call(reversed + "}").id, id);
}

TEST(ContourJson, identity_tells_questions_apart) {
  const json plain = ball_request();
  const std::pair<const char*, json> changes[] = {
      {"/scene/length_unit", "mm"},  {"/scene/quantity", "photometric"},
      {"/scene/light/intensity", 2}, {"/levels", {0.0003}},
      {"/include", {"isolux"}},      {"/tolerance", {{"irradiance", 1e-8}}},
      {"/families", {{"ball"}}},     {"/scene/surfaces/0/name", "bell"},
  };
  std::set<std::string> ids{id_of(plain)};
  for (const auto& [pointer, value] : changes) {
    json request = plain;
    request[json::json_pointer(pointer)] = value;
    EXPECT_TRUE(ids.insert(id_of(request)).second) << pointer;
  }
}

TEST(ContourJson, id_is_hash_of_the_request_and_the_version) {
  EXPECT_EQ(sha256_hex("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const ContourCall call = read_contour_call(ball_request().dump());
  EXPECT_TRUE(is_id(call.id) && is_id(call.request_sha256));
  EXPECT_NE(call.id, call.request_sha256);
  EXPECT_FALSE(is_id(call.id + "0") || is_id("A" + call.id.substr(1)) || is_id(""));
}

TEST(ContourJson, reads_levels) {
  json request = ball_request();
  request["levels"] = {{"count", 10}, {"spacing", "1-2-5"}, {"min", 1e-3}, {"max", 2}};
  const auto levels = read_contour_call(request.dump()).request.levels;
  EXPECT_EQ(levels.count, 10);
  EXPECT_EQ(levels.spacing, solver::LevelRequest::Spacing::one_two_five);
  EXPECT_EQ(levels.min, 1e-3);
  EXPECT_EQ(levels.max, 2.0);
}

TEST(ContourJson, refuses_meaningless_members) {
  const std::tuple<const char*, const char*, const char*> cases[] = {
      {"/levels", "[]", "/levels"},
      {"/levels", "[0.1,-1]", "/levels/1"},
      {"/levels", R"({"count":0})", "/levels/count"},
      {"/levels", R"({"count":2.5})", "/levels/count"},
      {"/levels", R"({"count":1001})", "/levels/count"},
      {"/levels", R"({"min":2,"max":1})", "/levels/max"},
      {"/levels", R"({"min":0})", "/levels/min"},
      {"/levels", R"({"spacing":"cubic"})", "/levels/spacing"},
      {"/levels", R"({"step":1})", "/levels/step"},
      {"/families", "[]", "/families"},
      {"/families", "[[]]", "/families/0"},
      {"/families", R"([["ball"],["ball"]])", "/families/1"},
      {"/families", R"([["nobody"]])", "/families/0/0"},
      {"/families", R"([[1]])", "/families/0/0"},
      {"/families", R"({"max_bounces":9})", "/families/max_bounces"},
      {"/families", R"({"min_flux_share":2})", "/families/min_flux_share"},
      {"/include", "[]", "/include"},
      {"/include", R"(["shadows"])", "/include/0"},
      {"/measure", R"("median")", "/measure"},
      {"/tolerance", R"({"chord":0})", "/tolerance/chord"},
      {"/tolerance", R"({"chord":13})", "/tolerance/chord"},
      {"/limits", R"({"time_ms":60001})", "/limits/time_ms"},
      {"/limits", R"({"time_ms":0})", "/limits/time_ms"},
      {"/limits", R"({"vertices":0})", "/limits/vertices"},
      {"/store", "1", "/store"},
      {"/extra", "1", "/extra"},
  };
  for (const auto& [pointer, value, fault] : cases) {
    json request = ball_request();
    request[json::json_pointer(pointer)] = json::parse(value);
    EXPECT_EQ(pointers_of(request), Pointers{fault}) << value;
  }
}

TEST(ContourJson, reads_families_of_many_hops) {
  json request = ball_request();
  test::surface(request)["optics"] = {
      {"type", "refract"}, {"index_outside", 1}, {"index_inside", 1.5}};
  request["families"] = json::array({json::array({"ball", "ball"})});
  EXPECT_EQ(read_contour_call(request.dump()).request.families,
            (std::vector<std::vector<int>>{{0, 0}}));
  request["families"] = {{"max_bounces", 3}, {"min_flux_share", 1e-3}};
  const ContourCall call = read_contour_call(request.dump());
  EXPECT_TRUE(call.request.families.empty());
  EXPECT_EQ(call.request.max_bounces, 3);
  EXPECT_EQ(call.request.min_flux_share, 1e-3);
  request["families"] = json::array({std::vector<std::string>(9, "ball")});
  EXPECT_EQ(pointers_of(request), Pointers{"/families/0"});
}

TEST(ContourJson, light_does_not_return_to_a_plane) {
  json request = ball_request();
  test::surface(request)["shape"] = {
      {"type", "plane"}, {"point", {0, 0, 0}}, {"normal", {0, 0, 1}}};
  request["families"] = json::array({json::array({"ball", "ball"})});
  EXPECT_EQ(pointers_of(request), Pointers{"/families/0/1"});
}

TEST(ContourJson, a_family_needs_a_mirror) {
  json request = ball_request();
  test::surface(request)["optics"] = {{"type", "absorb"}};
  request["families"] = {{"ball"}};
  EXPECT_EQ(pointers_of(request), Pointers{"/families/0/0"});
}

}  // namespace
}  // namespace caustic::service
