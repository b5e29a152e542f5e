// The program as a user calls it.
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "tests/support/program.h"
#include "tests/support/requests.h"
#include "tests/support/temporary_folder.h"

namespace caustic::test {
namespace {

using nlohmann::json;

class CommandLineTest : public testing::Test {
 protected:
  std::string file(const std::string& name) { return (folder.path() / name).string(); }
  std::string request_file(const json& request) {
    std::ofstream(file("request.json")) << request.dump();
    return file("request.json");
  }
  TemporaryFolder folder;
};

TEST_F(CommandLineTest, traces_into_every_format) {
  const std::string request = request_file(ball_request());
  const std::pair<const char*, const char*> beginnings[] = {
      {"vtp", "<?xml"},     {"vtk", "# vtk DataFile Version 4.2"},
      {"svg", "<svg"},      {"geojson", "{\"type\":\"FeatureCollection\""},
      {"csv", "curve_id,"}, {"json", "{\"id\":"}};
  for (const auto& [suffix, beginning] : beginnings) {
    const std::string out = file(std::string("out.") + suffix);
    const ProgramResult result = run_program({"trace", request, "-o", out});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_TRUE(read_file(out).starts_with(beginning)) << suffix;
    const ProgramResult piped = run_program({"trace", "-", "--format", suffix}, read_file(request));
    EXPECT_TRUE(piped.out.starts_with(beginning)) << suffix;
    const bool tells_seconds = suffix == std::string("json");
    EXPECT_TRUE(tells_seconds || piped.out == read_file(out)) << suffix;
  }
  EXPECT_TRUE(run_program({"trace", "-", "-o", "-"}, read_file(request)).out.starts_with("<?xml"));
}

TEST_F(CommandLineTest, bad_input_is_2_with_the_problem_on_stderr) {
  json request = ball_request();
  surface(request)["shape"]["radius"] = -1;
  const ProgramResult bad = run_program({"trace", request_file(request), "-o", file("out.vtp")});
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_EQ(json::parse(bad.err)["errors"][0]["pointer"], "/scene/surfaces/0/shape/radius");
  EXPECT_FALSE(std::filesystem::exists(file("out.vtp")));
  EXPECT_EQ(run_program({"trace", "-"}, "{").exit_code, 2);
  EXPECT_EQ(run_program({"trace", "-", "-o", file("out.xyz")}, "{}").exit_code, 2);
  EXPECT_EQ(run_program({"trace", "-", "-o", file("out")}, "{}").exit_code, 2);
  EXPECT_EQ(run_program({"trace", file("absent.json"), "-o", file("out.vtp")}).exit_code, 2);
  EXPECT_EQ(run_program({"trace"}).exit_code, 2);
  EXPECT_EQ(run_program({"dance"}).exit_code, 2);
  EXPECT_EQ(run_program({}).exit_code, 2);
}

TEST_F(CommandLineTest, runs_stages_that_a_scene_does_not_need) {
  const std::string request = request_file(ball_request());
  const auto trace = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"trace", request, "--format", "csv"});
    return run_program(more);
  };
  const ProgramResult planned = trace({});
  EXPECT_EQ(planned.exit_code, 0);
  EXPECT_EQ(trace({"--no-skip", "visibility"}).out, planned.out);
  EXPECT_EQ(trace({"--no-skip", "visibility", "--no-skip", "embree"}).out, planned.out);
  EXPECT_EQ(trace({"--no-skip", "lunch"}).exit_code, 2);
  const json forced = json::parse(
      run_program({"trace", request, "--format", "json", "--no-skip", "dark_side"}).out);
  for (const json& skipped : forced["skipped"]) EXPECT_NE(skipped["stage"], "dark_side");
}

TEST_F(CommandLineTest, reads_irradiance) {
  const ProgramResult result = run_program({"irradiance", request_file(irradiance_request())});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(json::parse(result.out)["points"].size(), 2u);
  EXPECT_EQ(run_program({"irradiance", "-"}, irradiance_request().dump()).out, result.out);
  json request = irradiance_request();
  request["points"] = json::array();
  const ProgramResult bad = run_program({"irradiance", "-"}, request.dump());
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_EQ(bad.out, "");
  EXPECT_EQ(json::parse(bad.err)["errors"][0]["pointer"], "/points");
  EXPECT_EQ(run_program({"irradiance", file("absent.json")}).exit_code, 2);
  EXPECT_EQ(run_program({"irradiance"}).exit_code, 2);
}

TEST_F(CommandLineTest, analyses) {
  const ProgramResult result = run_program({"analysis", request_file(analysis_request())});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(json::parse(result.out)["levels"].size(), 2u);
  json request = analysis_request();
  request["levels"] = json::array();
  const ProgramResult bad = run_program({"analysis", "-"}, request.dump());
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_EQ(json::parse(bad.err)["errors"][0]["pointer"], "/levels");
}

TEST_F(CommandLineTest, what_fails_is_1) {
  const std::string request = request_file(ball_request());
  EXPECT_EQ(run_program({"trace", request, "-o", file("no/such/folder/out.vtp")}).exit_code, 1);
  EXPECT_EQ(run_program({"health", "--port", "1"}).exit_code, 1);
  std::ofstream(file("plain")) << "a file";
  EXPECT_EQ(run_program({"serve", "--port", "0", "--data", file("plain/data")}).exit_code, 1);
}

TEST_F(CommandLineTest, prints_examples) {
  const ProgramResult list = run_program({"example"});
  EXPECT_EQ(list.exit_code, 0);
  EXPECT_NE(list.out.find("sphere-wall"), std::string::npos);
  const ProgramResult example = run_program({"example", "sphere-wall"});
  EXPECT_EQ(example.exit_code, 0);
  const ProgramResult traced = run_program({"trace", "-", "--format", "json"}, example.out);
  EXPECT_EQ(json::parse(traced.out)["complete"], true);
  EXPECT_EQ(run_program({"example", "none"}).exit_code, 2);
}

TEST_F(CommandLineTest, asks_a_server_for_its_health) {
  ServerProcess server(folder.path() / "data");
  const std::string port = std::to_string(server.port());
  EXPECT_EQ(run_program({"health", "--port", port}).exit_code, 0);
  EXPECT_EQ(run_program({"serve", "--port", port, "--data", file("x")}).exit_code,
            1);  // port taken
  EXPECT_EQ(server.stop(SIGTERM), 0);
  EXPECT_EQ(run_program({"health", "--port", port}).exit_code, 1);
}

TEST_F(CommandLineTest, a_public_address_must_be_meant) {
  const ProgramResult result = run_program({"serve", "--host", "0.0.0.0", "--port", "0"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("--public"), std::string::npos);
}

TEST_F(CommandLineTest, tells_its_version) {
  EXPECT_EQ(run_program({"--version"}).out, "isocaustic 0.1.0\n");
  EXPECT_EQ(run_program({"--help"}).exit_code, 0);
}

}  // namespace
}  // namespace caustic::test
