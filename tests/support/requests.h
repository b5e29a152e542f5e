// Request bodies for tests, to be changed member by member.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace caustic::test {

/// A mirror ball over a receiver; a name that XML and JSON must escape.
inline nlohmann::json ball_request() {
  return nlohmann::json::parse(R"({
    "scene": {
      "light": {"type": "point", "position": [0.3, 0.2, 4], "intensity": 1},
      "surfaces": [{"name": "ball", "shape": {"type": "sphere", "center": [0, 0, 0], "radius": 1},
                    "optics": {"type": "mirror", "reflectance": 1}}],
      "receiver": {"type": "plane", "origin": [0, 0, 6], "u_axis": [1, 0, 0], "v_axis": [0, 1, 0],
                   "size": [12, 12]}},
    "levels": [0.0003, 0.0005]})");
}

/// From the lamp over the ball to a point beside it, with everything that there is to ask.
inline nlohmann::json path_request() {
  nlohmann::json request{{"scene", ball_request()["scene"]}};
  request["from"] = {0.3, 0.2, 4};
  request["to"] = {2, 1, 3};
  request["hessians"] = true;
  request["certify"] = true;
  request["perturb"] = {0.01, 0.0, 0.02};
  return request;
}

inline nlohmann::json irradiance_request() {
  nlohmann::json request{{"scene", ball_request()["scene"]}};
  request["direct"] = true;
  request["points"] = {{0.0, 0.0}, {1.5, -2.0}};
  return request;
}

inline nlohmann::json analysis_request() {
  nlohmann::json request{{"scene", ball_request()["scene"]}};
  request["levels"] = {0.0005, 0.0003};
  return request;
}

inline nlohmann::json& surface(nlohmann::json& request, std::size_t i = 0) {
  return request["scene"]["surfaces"][i];
}

/// Many seconds of work, if nothing ends it: a proof that runs into its limits.
inline nlohmann::json long_request(int variant = 0) {
  nlohmann::json request = ball_request();
  surface(request)["shape"] = {{"type", "torus"},
                               {"center", {0, 0, 0}},
                               {"axis", {0, 0, 1}},
                               {"major_radius", 1},
                               {"minor_radius", 0.4}};
  request["tolerance"] = {{"irradiance", 1e-12}, {"chord", 2e-8}};
  request["limits"] = {{"time_ms", 60000}, {"vertices", 2000000}, {"cells", 10000000}};
  request["measure"] = "sheet";
  request["certify"] = true;
  request["levels"] = {0.0003, 0.0004 + 1e-6 * variant, 0.0005};
  return request;
}

}  // namespace caustic::test
