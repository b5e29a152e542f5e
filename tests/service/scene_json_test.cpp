#include "service/api/scene_json.h"

#include <gtest/gtest.h>

#include <map>

#include "service/api/contour_json.h"
#include "tests/support/faults.h"
#include "tests/support/requests.h"

namespace caustic::service {
namespace {

using nlohmann::json;
using test::ball_request;
using test::faults_of;
using test::pointers_of;
using test::surface;

using Pointers = std::vector<std::string>;

json with_shape(const char* shape) {
  json request = ball_request();
  surface(request)["shape"] = json::parse(shape);
  return request;
}

TEST(SceneJson, names_every_fault_at_once) {
  const json request = json::parse(R"({
    "scene": {
      "length_unit": "parsec", "colour": 1,
      "light": {"type": "point", "position": [0, "x", 4], "intensity": -1},
      "surfaces": [
        {"name": "a", "shape": {"type": "sphere", "center": [0, 0], "radius": -1}},
        {"name": "a", "shape": {"type": "torus", "center": [0,0,0], "axis": [0,0,0],
                                "major_radius": 1, "minor_radius": 2},
         "optics": {"type": "mirror", "reflectance": 1.5, "a/b~c": 0},
         "aperture": [{"type": "box", "min": [0,0,0], "max": [1,0,1]}]}],
      "receiver": {"type": "plane", "origin": [0,0,0], "u_axis": [1,0,0], "v_axis": [-2,0,0],
                   "size": [1, 0]}},
    "families": [["b"]],
    "levels": [1, 0],
    "tolerance": {"irradiance": 2}})");
  const Pointers expected{
      "/families/0/0",
      "/levels/1",
      "/scene/colour",
      "/scene/length_unit",
      "/scene/light/intensity",
      "/scene/light/position/1",
      "/scene/receiver/size/1",
      "/scene/surfaces/0/optics",
      "/scene/surfaces/0/shape/center",
      "/scene/surfaces/0/shape/radius",
      "/scene/surfaces/1/aperture/0/max/1",
      "/scene/surfaces/1/name",
      "/scene/surfaces/1/optics/a~1b~0c",
      "/scene/surfaces/1/optics/reflectance",
      "/scene/surfaces/1/shape/axis",
      "/tolerance/irradiance",
  };
  EXPECT_EQ(pointers_of(request), expected);
}

TEST(SceneJson, wants_what_has_no_default) {
  EXPECT_EQ(pointers_of(json::object()), Pointers{"/scene"});
  json request = ball_request();
  request["scene"] = json::object();
  EXPECT_EQ(pointers_of(request), (Pointers{"/scene/light", "/scene/receiver", "/scene/surfaces"}));
  request = ball_request();
  surface(request) = json::object();
  EXPECT_EQ(pointers_of(request), (Pointers{"/scene/surfaces/0/name", "/scene/surfaces/0/optics",
                                            "/scene/surfaces/0/shape"}));
  request["scene"]["surfaces"] = json::array();
  EXPECT_EQ(pointers_of(request), Pointers{"/scene/surfaces"});
}

TEST(SceneJson, wants_the_right_types) {
  for (const char* wrong : {"1", "\"x\"", "true", "null", "[]", "[1,2]", "{}"}) {
    EXPECT_FALSE(faults_of(json::parse(wrong)).empty()) << wrong;
    for (const char* member : {"scene", "families", "tolerance", "limits", "include"}) {
      json request = ball_request();
      request[member] = json::parse(wrong);
      const bool may_be_empty = std::string(wrong) == "{}" && member != std::string("scene") &&
                                member != std::string("include");
      EXPECT_EQ(faults_of(request).empty(), may_be_empty) << member << " " << wrong;
    }
    for (const char* member : {"light", "surfaces", "receiver"}) {
      json request = ball_request();
      request["scene"][member] = json::parse(wrong);
      EXPECT_FALSE(faults_of(request).empty()) << member << " " << wrong;
    }
  }
}

TEST(SceneJson, refuses_shapes_that_are_none) {
  const std::pair<const char*, const char*> cases[] = {
      {R"({"type":"plane","point":[0,0,0],"normal":[0,0,0]})", "normal"},
      {R"({"type":"sphere","center":[0,0,0],"radius":0})", "radius"},
      {R"({"type":"ellipsoid","center":[0,0,0],"semi_axes":[1,-1,1]})", "semi_axes/1"},
      {R"({"type":"quadric","coefficients":[1,1,1]})", "coefficients"},
      {R"({"type":"quadric","coefficients":[1,1,1,0,0,0,0,0,0,1]})", "coefficients"},
      {R"({"type":"cone","point":[0,0,0],"axis":[0,0,1],"half_angle_degrees":90})",
       "half_angle_degrees"},
      {R"({"type":"torus","center":[0,0,0],"axis":[0,0,1],"major_radius":1,"minor_radius":1})",
       "minor_radius"},
      {R"({"type":"conic","vertex":[0,0,0],"axis":[0,0,1],"radius_of_curvature":0,"conic_constant":0})",
       "radius_of_curvature"},
      {R"({"type":"revolution","origin":[0,0,0],"axis":[0,0,1],"height":0,"profile":[1]})",
       "height"},
      {R"({"type":"revolution","origin":[0,0,0],"axis":[0,0,0],"height":1,"profile":[1]})", "axis"},
      {R"({"type":"revolution","origin":[0,0,0],"axis":[0,0,1],"height":1,"profile":[1,-2]})",
       "profile"},
      {R"({"type":"revolution","origin":[0,0,0],"axis":[0,0,1],"height":1,"profile":[]})",
       "profile"},
      {R"({"type":"revolution","origin":[0,0,0],"axis":[0,0,1],"height":1,"profile":[1,"x"]})",
       "profile/1"},
      {R"({"type":"revolution","origin":[0,0,0],"axis":[0,0,1],"height":1})", "profile"},
      {R"~({"type":"expression","expression":"x^^2","bounds":{"min":[-1,-1,-1],"max":[1,1,1]}})~",
       "expression"},
      {R"~({"type":"expression","expression":"tan(x)","bounds":{"min":[-1,-1,-1],"max":[1,1,1]}})~",
       "expression"},
      {R"~({"type":"expression","expression":"1/(x-x)","bounds":{"min":[-1,-1,-1],"max":[1,1,1]}})~",
       "expression"},
      {R"~({"type":"expression","expression":"sqrt(-1-x^2)","bounds":{"min":[-1,-1,-1],"max":[1,1,1]}})~",
       "expression"},
      {R"~({"type":"expression","expression":"7","bounds":{"min":[-1,-1,-1],"max":[1,1,1]}})~",
       "expression"},
      {R"~({"type":"expression","expression":"(x^2+y^2+z^2-1)^2","bounds":{"min":[-2,-2,-2],"max":[2,2,2]}})~",
       "expression"},
      {R"~({"type":"expression","expression":"x^2+y^2+z^2-9","bounds":{"min":[-1,-1,-1],"max":[1,1,1]}})~",
       "bounds"},
      {R"~({"type":"expression","expression":"x","bounds":{"min":[-1,-1,-1],"max":[1,-1,1]}})~",
       "bounds/max/1"},
      {R"~({"type":"expression","expression":"x"})~", "bounds"},
      {R"~({"type":"expression","bounds":{"min":[-1,-1,-1],"max":[1,1,1]}})~", "expression"},
      {R"({"type":"cube"})", "type"},
      {R"({"type":7})", "type"},
  };
  for (const auto& [shape, member] : cases)
    EXPECT_EQ(pointers_of(with_shape(shape)),
              Pointers{std::string("/scene/surfaces/0/shape/") + member})
        << shape;
}

TEST(SceneJson, says_what_this_version_lacks) {
  const std::pair<const char*, const char*> cases[] = {
      {"/scene/light", R"({"type":"photometric_file","content":"x"})"},
  };
  for (const auto& [pointer, value] : cases) {
    json request = ball_request();
    request[json::json_pointer(pointer)] = json::parse(value);
    const auto faults = faults_of(request);
    ASSERT_FALSE(faults.empty()) << value;
    for (const auto& [place, detail] : faults) {
      EXPECT_TRUE(place.starts_with(pointer)) << place;
      EXPECT_NE(detail.find("not supported by this version"), std::string::npos) << detail;
    }
  }
}

TEST(SceneJson, reads_optics) {
  const auto optics_of = [](const char* text) {
    json request = ball_request();
    request["scene"]["surfaces"][0]["optics"] = json::parse(text);
    return read_contour_call(request.dump()).system.surfaces()[0].optics;
  };
  const auto glass =
      optics_of(R"({"type":"refract","index_outside":1,"index_inside":1.5,"fresnel":true})");
  EXPECT_EQ(glass.kind, solver::Optics::Kind::refract);
  EXPECT_EQ(glass.eta(1), 1.0 / 1.5);
  EXPECT_EQ(glass.eta(-1), 1.5);
  EXPECT_NEAR(glass.share(1, 1.0).value, 0.96, 1e-15);
  const auto silver = optics_of(R"({"type":"mirror","n":0.05,"k":4})");
  EXPECT_EQ(silver.metal, std::complex(0.05, 4.0));
}

TEST(SceneJson, names_what_is_wrong_with_optics) {
  const std::pair<const char*, Pointers> cases[] = {
      {R"({"type":"refract","index_inside":1.3})", {"index_outside"}},
      {R"({"type":"refract","index_inside":0,"index_outside":-1})",
       {"index_inside", "index_outside"}},
      {R"({"type":"refract","index_inside":1,"index_outside":1,"fresnel":1})", {"fresnel"}},
      {R"({"type":"mirror","n":0.2})", {"k"}},
      {R"({"type":"mirror","n":0,"k":-1})", {"k", "n"}},
      {R"({"type":"mirror","n":1,"k":1,"reflectance":0.5})", {"reflectance"}},
      {R"({"type":"absorb","n":1})", {"n"}},
  };
  for (const auto& [optics, members] : cases) {
    json request = ball_request();
    request["scene"]["surfaces"][0]["optics"] = json::parse(optics);
    Pointers expected;
    for (const auto& member : members) expected.push_back("/scene/surfaces/0/optics/" + member);
    EXPECT_EQ(pointers_of(request), expected) << optics;
  }
}

TEST(SceneJson, reads_every_shape) {
  for (
      const char* shape :
      {R"({"type":"plane","point":[0,0,0],"normal":[0,0,3]})",
       R"({"type":"sphere","center":[0,0,0],"radius":1})",
       R"({"type":"ellipsoid","center":[0,0,0],"semi_axes":[1,2,3]})",
       R"({"type":"quadric","coefficients":[1,1,1,0,0,0,0,0,0,-1]})",
       R"({"type":"cylinder","point":[0,0,0],"axis":[0,0,1],"radius":1})",
       R"~({"type":"expression","expression":"x^2+y^2+z^2-1","bounds":{"min":[-2,-2,-2],"max":[2,2,2]}})~",
       R"({"type":"cone","point":[0,0,0],"axis":[0,0,1],"half_angle_degrees":30})",
       R"({"type":"torus","center":[0,0,0],"axis":[0,0,1],"major_radius":2,"minor_radius":1})",
       R"({"type":"conic","vertex":[0,0,0],"axis":[0,0,1],"radius_of_curvature":-2,"conic_constant":-1,"aspheric":[0.01]})",
       R"({"type":"revolution","origin":[0,0,0],"axis":[0,0,1],"height":2,"profile":[0.47,3.9,-9.78,5.8]})",
       R"({"type":"sag","origin":[0,0,0],"x_axis":[1,0,0],"y_axis":[1,1,0],"kind":"xy_polynomial","terms":[{"i":2,"j":0,"c":0.1}]})",
       R"({"type":"sag","origin":[0,0,0],"x_axis":[1,0,0],"y_axis":[0,1,0],"kind":"zernike","norm_radius":1,"coefficients":{"4":0.1,"230":0}})"})
    EXPECT_EQ(pointers_of(with_shape(shape)), Pointers{}) << shape;
}

/// A point of each surface, in the request's unit, and the same surface in all units.
TEST(SceneJson, converts_lengths_once) {
  const std::pair<const char*, double> units[] = {
      {"m", 1}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}};
  struct Case {
    const char* shape;
    geometry::Vec3 on;  // a point on the surface
  };
  const Case cases[] = {
      {R"({"type":"plane","point":[1,2,3],"normal":[0,0,1]})", {7, 8, 3}},
      {R"({"type":"sphere","center":[1,0,0],"radius":2})", {3, 0, 0}},
      {R"({"type":"ellipsoid","center":[0,0,0],"semi_axes":[1,2,3]})", {0, 0, 3}},
      {R"({"type":"quadric","coefficients":[1,1,1,0,0,0,-1,0,0,-3]})", {3, 0, 0}},
      {R"({"type":"quadric","coefficients":[1,1,0,0,0,0,0,0,-1,0]})", {1, 1, 1}},
      {R"({"type":"cylinder","point":[0,0,0],"axis":[0,0,1],"radius":2})", {0, 2, 5}},
      {R"~({"type":"expression","expression":"z-x^3/4-y","bounds":{"min":[-3,-3,-3],"max":[3,3,4]}})~",
       {2, 1, 3}},
      {R"({"type":"torus","center":[0,0,0],"axis":[0,0,1],"major_radius":2,"minor_radius":1})",
       {0, 3, 0}},
      {R"({"type":"conic","vertex":[0,0,0],"axis":[0,0,1],"radius_of_curvature":2,"conic_constant":-1,"aspheric":[0.125,0.25]})",
       {1, 0, 0.25 + 0.125 + 0.25}},
      {R"({"type":"revolution","origin":[0,0,1],"axis":[0,0,1],"height":2,"profile":[1,2,4]})",
       {0, 3, 2}},
      {R"({"type":"sag","origin":[0,0,1],"x_axis":[2,0,0],"y_axis":[5,1,0],"kind":"xy_polynomial","terms":[{"i":0,"j":0,"c":0.5},{"i":2,"j":1,"c":0.25},{"i":0,"j":1,"c":-1}]})",
       {2, 1, 1.5}},
      {R"({"type":"sag","origin":[0,1,0],"x_axis":[1,0,0],"y_axis":[0,1,0],"kind":"zernike","norm_radius":2,"coefficients":{"0":0.5,"1":0.25}})",
       {0.3, 3, 1}},
  };
  for (const auto& [unit, metres] : units) {
    for (const Case& c : cases) {
      json request = with_shape(c.shape);
      request["scene"]["length_unit"] = unit;
      surface(request)["pose"] = {{"rotate", {{"axis", {0, 0, 1}}, {"degrees", 90}}},
                                  {"translate", {0, 0, 10}}};
      const ContourCall call = read_contour_call(request.dump());
      const geometry::Vec3 posed(-c.on.y(), c.on.x(), c.on.z() + 10);
      EXPECT_NEAR(call.system.surfaces()[0].shape->value(metres * posed) / metres, 0.0, 1e-12)
          << unit << " " << c.shape;
    }
  }
}

TEST(SceneJson, reads_apertures_by_expression) {
  json request = ball_request();
  request["scene"]["length_unit"] = "cm";
  surface(request)["aperture"] =
      json::parse(R"~([{"type":"expression","expression":"x^2+y^2-0.25"}])~");
  const ContourCall call = read_contour_call(request.dump());
  const auto& bounds = call.system.surfaces()[0].bounds;
  for (const double r : {0.49, 0.51})
    EXPECT_EQ(geometry::exists_at(bounds, {0.01 * r, 0.0, 0.01}), r < 0.5);
  for (const char* wrong : {"x+", "", "5", "0/0"}) {
    surface(request)["aperture"][0]["expression"] = wrong;
    EXPECT_EQ(pointers_of(request), Pointers{"/scene/surfaces/0/aperture/0/expression"}) << wrong;
  }
}

TEST(SceneJson, says_where_an_expression_is_wrong) {
  json request = with_shape(
      R"~({"type":"expression","expression":"x^2 + tan(y)","bounds":{"min":[-1,-1,-1],"max":[1,1,1]}})~");
  EXPECT_NE(faults_of(request)["/scene/surfaces/0/shape/expression"].find(
                "unknown function \"tan\" (sqrt, sin, cos, exp, log, abs) at column 7"),
            std::string::npos);
}

TEST(SceneJson, converts_the_rest_too) {
  json request = ball_request();
  request["scene"]["length_unit"] = "mm";
  request["scene"]["light"] = {{"type", "point"}, {"position", {0, 0, 4}}, {"power", 4.0}};
  request["tolerance"] = {{"chord", 0.5}};
  const ContourCall call = read_contour_call(request.dump());
  const auto& light = std::get<solver::PointLight>(call.system.light());
  EXPECT_DOUBLE_EQ(light.intensity, 1.0 / geometry::kPi);
  EXPECT_DOUBLE_EQ(light.position.z(), 0.004);
  EXPECT_DOUBLE_EQ(call.request.chord_tolerance, 0.0005);
  EXPECT_DOUBLE_EQ(call.system.receiver().half.x(), 0.006);
}

TEST(SceneJson, makes_directions_of_any_length) {
  json request = ball_request();
  request["scene"]["light"] = {
      {"type", "collimated"}, {"direction", {0, 3e-25, 4e-25}}, {"irradiance", 2}};
  const ContourCall call = read_contour_call(request.dump());
  const auto& light = std::get<solver::CollimatedLight>(call.system.light());
  EXPECT_DOUBLE_EQ(light.direction.y(), 0.6);
  EXPECT_DOUBLE_EQ(light.direction.z(), 0.8);
}

TEST(SceneJson, refuses_parallel_axes) {
  json request = ball_request();
  request["scene"]["receiver"]["v_axis"] = {2, 1e-12, 0};
  EXPECT_EQ(pointers_of(request), Pointers{"/scene/receiver/v_axis"});
}

TEST(SceneJson, takes_any_printable_name) {
  json request = ball_request();
  for (const char* name : {"<&\"'>", "é😀", "a/b~c", "]]>"}) {
    surface(request)["name"] = name;
    request["families"] = {{name}};
    EXPECT_EQ(pointers_of(request), Pointers{}) << name;
  }
  for (const std::string& name :
       {std::string(), std::string("a\nb"), std::string("\0", 1), std::string(201, 'x')}) {
    surface(request)["name"] = name;
    request["families"] = {{name}};
    EXPECT_EQ(pointers_of(request), Pointers{"/scene/surfaces/0/name"}) << name;
  }
}

TEST(SceneJson, limits_the_number_of_surfaces) {
  json request = ball_request();
  json& surfaces = request["scene"]["surfaces"];
  const json ball = surfaces[0];
  for (std::size_t i = 1; i < kMaxSurfaces + 1; ++i) {
    surfaces.push_back(ball);
    surfaces.back()["name"] = "ball" + std::to_string(i);
  }
  EXPECT_EQ(pointers_of(request), Pointers{"/scene/surfaces"});
  for (json& s : surfaces) s["name"] = 1;
  surfaces.erase(0);
  try {
    read_contour_call(request.dump());
    FAIL();
  } catch (const ProblemError& error) {
    EXPECT_EQ(error.problem().errors.size(), 1000u);  // and the detail says that there are more
    EXPECT_NE(error.problem().detail.find("10000 faults"), std::string::npos);
  }
}

}  // namespace
}  // namespace caustic::service
