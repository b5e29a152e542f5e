#include "service/point_service.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "service/api/problem.h"
#include "service/examples/examples.h"
#include "tests/support/requests.h"

namespace caustic::service {
namespace {

using nlohmann::json;
using test::irradiance_request;
using test::path_request;

json paths(const json& request) { return json::parse(answer_paths(request.dump())); }
json irradiance(const json& request) { return json::parse(answer_irradiance(request.dump())); }

template <class Call>
std::vector<std::string> faults(Call call, const json& request) {
  std::vector<std::string> pointers;
  try {
    call(request);
    ADD_FAILURE() << "no fault found";
  } catch (const ProblemError& error) {
    EXPECT_EQ(error.problem().status, 422);
    for (const Fault& fault : error.problem().errors) pointers.push_back(fault.pointer);
  }
  return pointers;
}
using Pointers = std::vector<std::string>;

/// A plane mirror z = 0, whose paths are those of the mirrored source.
json plane_request(const json& base, double units) {
  json request = base;
  json& scene = request["scene"];
  scene["surfaces"][0]["shape"] = {{"type", "plane"}, {"point", {0, 0, 0}}, {"normal", {0, 0, 1}}};
  scene["surfaces"][0]["optics"]["reflectance"] = 0.8;
  scene["light"]["position"] = {0, 0, 1 * units};
  scene["receiver"]["origin"] = {0, 0, 2 * units};
  scene["receiver"]["size"] = {4 * units, 4 * units};
  return request;
}

TEST(Paths, of_a_plane_mirror_are_those_of_the_mirrored_source) {
  for (const auto& [unit, units] : {std::pair{"m", 1.0}, std::pair{"cm", 100.0}}) {
    json request = plane_request(path_request(), units);
    request["scene"]["length_unit"] = unit;
    request["from"] = {0, 0, 1 * units};
    request["to"] = {3 * units, 0, 2 * units};
    request["perturb"] = {0.03 * units, 0, 0};
    const json answer = paths(request);
    ASSERT_EQ(answer["paths"].size(), 1u);
    EXPECT_EQ(answer["completeness"], json::parse(R"({"certified":true,"undecided_cells":0})"));
    const json& path = answer["paths"][0];
    EXPECT_EQ(path["family_id"], 0);
    ASSERT_EQ(path["vertices"].size(), 1u);
    EXPECT_NEAR(path["vertices"][0][0].get<double>(), 1 * units, 1e-12 * units);
    EXPECT_NEAR(path["optical_length"].get<double>(), std::sqrt(18.0) * units, 1e-12 * units);
    EXPECT_NEAR(path["determinant"].get<double>(), 18.0 * units * units, 1e-10 * units * units);
    // x = p_x s_z/(p_z + s_z): ∂x/∂p_x = 1/3, ∂x/∂p_z = −1/3, ∂²x/∂p_z² = 2/9, ∂²x/∂p_x∂p_z = −1/9.
    const json &J = path["jacobians"][0], &H = path["hessians"][0];
    EXPECT_NEAR(J[0][0].get<double>(), 1.0 / 3, 1e-13);
    EXPECT_NEAR(J[0][2].get<double>(), -1.0 / 3, 1e-13);
    EXPECT_NEAR(J[2][2].get<double>(), 0.0, 1e-13);
    EXPECT_NEAR(H[0][2][2].get<double>() * units, 2.0 / 9, 1e-13);
    EXPECT_NEAR(H[0][0][2].get<double>() * units, -1.0 / 9, 1e-13);
    const json& prediction = path["prediction"];
    EXPECT_NEAR(prediction["exact"][0][0].get<double>(), 1.01 * units, 1e-12 * units);
    EXPECT_NEAR(prediction["first_order_error"].get<double>(), 0.0, 1e-12 * units);
  }
}

TEST(Paths, answer_only_what_was_asked) {
  json request = path_request();
  for (const char* key : {"hessians", "certify", "perturb"}) request.erase(key);
  const json answer = paths(request);
  ASSERT_EQ(answer["paths"].size(), 1u);
  EXPECT_FALSE(answer["paths"][0].contains("hessians"));
  EXPECT_FALSE(answer["paths"][0].contains("prediction"));
  EXPECT_EQ(answer["completeness"]["certified"], false);
}

TEST(Paths, need_two_points) {
  json request = path_request();
  request["to"] = request["from"];
  EXPECT_EQ(faults(paths, request), Pointers{"/to"});
}

TEST(Paths, name_every_fault) {
  json request = path_request();
  request["from"] = {0, 0};
  request.erase("to");
  request["families"] = {{"nobody"}};
  request["certify"] = "yes";
  request["hesians"] = true;
  request["perturb"] = 3;
  EXPECT_EQ(faults(paths, request),
            (Pointers{"/from", "/to", "/families/0/0", "/certify", "/perturb", "/hesians"}));
}

TEST(Irradiance, of_a_plane_mirror_and_the_lamp_itself) {
  for (const auto& [unit, units] : {std::pair{"m", 1.0}, std::pair{"mm", 1000.0}}) {
    json request = plane_request(irradiance_request(), units);
    request["scene"]["length_unit"] = unit;
    request["points"] = {{1.5 * units, -1.0 * units}};
    const json point = irradiance(request)["points"][0];
    // E = ρ I h/(h² + r²)^(3/2) with the mirrored source at h = 3, and the lamp at h = 1.
    const double r2 = 1.5 * 1.5 + 1.0;
    const auto E = [&](double h) { return h / std::pow(h * h + r2, 1.5); };
    const auto slope = [&](double h) { return -3.0 * h / std::pow(h * h + r2, 2.5); };
    const double total = 0.8 * E(3) + E(1);
    EXPECT_NEAR(point["E"].get<double>(), total, 1e-13);
    EXPECT_EQ(point["on_caustic"], false);
    EXPECT_EQ(point["uv"][0].get<double>(), 1.5 * units);
    const double change = 0.8 * slope(3) + slope(1);
    EXPECT_NEAR(point["gradient"][0].get<double>() * units, 1.5 * change, 1e-13);
    EXPECT_NEAR(point["gradient"][1].get<double>() * units, -1.0 * change, 1e-13);
    EXPECT_NEAR(point["gradient"][2].get<double>() * units, 0.0, 1e-13);
    ASSERT_EQ(point["sheets"].size(), 2u);
    const json &sheet = point["sheets"][0], &direct = point["sheets"][1];
    EXPECT_EQ(direct["family_id"], -1);
    EXPECT_EQ(direct["parity"], -1);  // the lamp is on the side of −m
    EXPECT_NEAR(direct["E"].get<double>(), E(1), 1e-13);
    EXPECT_NEAR(direct["gradient"][0].get<double>() * units, 1.5 * slope(1), 1e-13);
    EXPECT_NEAR(direct["x"][0].get<double>(), 1.5 * units, 1e-12 * units);
    EXPECT_EQ(direct["vertices"], json::array());
    EXPECT_NEAR(sheet["E"].get<double>(), 0.8 * E(3), 1e-13);
    EXPECT_EQ(sheet["family_id"], 0);
    EXPECT_EQ(sheet["parity"], 1);
    EXPECT_NEAR(sheet["x"][0].get<double>(), 0.5 * units, 1e-12 * units);
    EXPECT_EQ(sheet["vertices"], json::array({sheet["x"]}));
  }
}

TEST(Irradiance, the_lamp_is_hidden_by_what_stands_before_it) {
  json request = irradiance_request();
  request["scene"]["receiver"]["origin"] = {0, 0, -3};  // in the shadow of the ball
  request["points"] = {{0, 0}, {5.9, 5.9}};
  const json points = irradiance(request)["points"];
  EXPECT_EQ(points[0]["E"], 0.0);
  EXPECT_GT(points[1]["E"].get<double>(), 0.0);
  request["direct"] = false;
  EXPECT_LT(irradiance(request)["points"][1]["E"].get<double>(), points[1]["E"].get<double>());
}

TEST(Irradiance, grid_is_cell_centres_u_fastest) {
  json request = irradiance_request();
  request.erase("points");
  request["grid"] = {{"nu", 3}, {"nv", 2}};
  const json points = irradiance(request)["points"];
  ASSERT_EQ(points.size(), 6u);
  const double u[] = {-4, 0, 4, -4, 0, 4}, v[] = {-3, -3, -3, 3, 3, 3};
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(points[i]["uv"][0].get<double>(), u[i], 1e-14);
    EXPECT_NEAR(points[i]["uv"][1].get<double>(), v[i], 1e-14);
  }
}

// The cusp of the nephroid: inside a cylinder of radius 1 a beam along +x, tilted down, meets at r
// = ½.
TEST(Irradiance, on_a_caustic_is_unbounded) {
  json request = irradiance_request();
  json& scene = request["scene"];
  scene["light"] = json::parse(R"({"type":"collimated","direction":[1,0,-1],"irradiance":1000})");
  scene["surfaces"][0] = json::parse(R"({"name":"ring","shape":{"type":"cylinder",
      "point":[0,0,0],"axis":[0,0,1],"radius":1},"optics":{"type":"mirror","reflectance":1},
      "aperture":[{"type":"box","min":[0,-1,0],"max":[1,1,2]}]})");
  scene["receiver"] = json::parse(R"({"type":"plane","origin":[0,0,0],"u_axis":[1,0,0],
      "v_axis":[0,1,0],"size":[2,2]})");
  const double phi = 0.6;
  const double u = std::cos(phi) - 0.5 * std::cos(phi) * std::cos(2 * phi);
  const double v = std::sin(phi) - 0.5 * std::cos(phi) * std::sin(2 * phi);
  request["direct"] = false;
  request["points"] = {{u, v}, {u - 1e-3, v}, {u + 1e-3, v}};
  const json points = irradiance(request)["points"];
  EXPECT_EQ(points[0]["on_caustic"], true);
  EXPECT_EQ(points[0]["E"], nullptr);
  EXPECT_EQ(points[1]["on_caustic"], false);
  EXPECT_EQ(points[2]["on_caustic"], false);
  // Two paths are born at it.
  EXPECT_EQ(std::abs(static_cast<int>(points[1]["sheets"].size()) -
                     static_cast<int>(points[2]["sheets"].size())),
            2);
}

TEST(Irradiance, names_every_fault) {
  json request = irradiance_request();
  request["points"] = {{0, 0}, {7, 0}, {1}};
  request["direct"] = 1;
  EXPECT_EQ(faults(irradiance, request), (Pointers{"/direct", "/points/2"}));
  request["direct"] = true;
  request["points"] = {{0, 0}, {7, 0}};
  EXPECT_EQ(faults(irradiance, request), Pointers{"/points/1"});
  request.erase("points");
  EXPECT_EQ(faults(irradiance, request), Pointers{"/points"});
  request["grid"] = {{"nu", 0}, {"nw", 2}};
  EXPECT_EQ(faults(irradiance, request), (Pointers{"/grid/nu", "/grid/nv", "/grid/nw"}));
  request["grid"] = {{"nu", 1000}, {"nv", 1000}};
  EXPECT_EQ(faults(irradiance, request), Pointers{"/grid"});
  request["grid"] = {{"nu", 2}, {"nv", 2}};
  request["points"] = {{0, 0}};
  EXPECT_EQ(faults(irradiance, request), Pointers{"/grid"});
}

/// A dozen seconds of proofs, if nothing breaks them off.
TEST(PointService, breaks_a_proof_off) {
  const json scene = json::parse(find_example("two-mirrors")->body)["scene"];
  const json request{{"scene", scene},
                     {"from", scene["light"]["position"]},
                     {"to", scene["receiver"]["origin"]},
                     {"families", {{"max_bounces", 8}}},
                     {"certify", true}};
  std::atomic<bool> cancelled = false;
  std::thread canceller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    cancelled = true;
  });
  int status = 200;
  try {
    answer_paths(request.dump(), &cancelled);
  } catch (const ProblemError& error) {
    status = error.problem().status;
  }
  canceller.join();
  EXPECT_EQ(status, 503);
}

TEST(PointService, stops_when_the_service_does) {
  const std::atomic<bool> stopping = true;
  for (const auto& call : {std::pair{&answer_paths, path_request()},
                           std::pair{&answer_irradiance, irradiance_request()}}) {
    try {
      call.first(call.second.dump(), &stopping);
      ADD_FAILURE() << "was answered";
    } catch (const ProblemError& error) {
      EXPECT_EQ(error.problem().status, 503);
    }
  }
}

}  // namespace
}  // namespace caustic::service
