#include "service/http/routes.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <nlohmann/json.hpp>
#include <thread>

#include "service/formats/format.h"
#include "tests/support/ask.h"
#include "tests/support/requests.h"
#include "tests/support/stub_engine.h"
#include "tests/support/temporary_folder.h"

namespace caustic::service {
namespace {

using nlohmann::json;
using test::ball_request;
using test::header;

class RoutesTest : public testing::Test {
 protected:
  HttpResponse ask(const std::string& method, const std::string& target,
                   const std::string& body = "", const std::string& type = "application/json") {
    return test::ask(routes, {method, target, type, body, false});
  }
  HttpResponse post(const json& request) { return ask("POST", "/v1/contours", request.dump()); }

  test::TemporaryFolder folder;
  ResultStore store{folder.path()};
  Engine engine = test::draw_circles;
  std::atomic<int> runs = 0;
  ContourService contours{[this](const auto& system, const auto& request) {
                            ++runs;
                            return engine(system, request);
                          },
                          store};
  Jobs jobs{{4, 16}};
  Routes routes{contours, store, jobs};
};

TEST_F(RoutesTest, answers_as_the_contract_says) {
  const HttpResponse response = post(ball_request());
  EXPECT_EQ(response.status, 200);
  EXPECT_EQ(response.content_type, "application/json");
  const json answer = json::parse(response.body);
  const std::string id = answer["id"];
  EXPECT_EQ(answer["engine_version"], "0.1.0");
  EXPECT_EQ(answer["complete"], true);
  EXPECT_EQ(answer["families"], json::parse(R"([{"id":0,"surfaces":["ball"],"flux":0.42}])"));
  EXPECT_EQ(answer["completeness"], json::parse(R"({"certified":false,"undecided_cells":0})"));
  EXPECT_EQ(answer["work"]["evaluations"], 1234);
  ASSERT_EQ(answer["curves"].size(), 3u);
  json isolux = answer["curves"][0], caustic = answer["curves"][2];
  EXPECT_NEAR(isolux["length"].get<double>(), 2 * 3.14159 * 3, 0.05);
  isolux.erase("length");
  caustic.erase("length");
  EXPECT_EQ(isolux, json::parse(R"({"curve_id":0,"kind":"isolux","level":0.0003,"measure":"sheet",
      "family_id":0,"parity":1,"closed":true,"ends":[],"vertices":64,"max_residual":1e-12})"));
  EXPECT_EQ(caustic, json::parse(R"({"curve_id":2,"kind":"caustic","level":null,"measure":"sheet",
      "family_id":0,"parity":0,"closed":false,"ends":["aperture","receiver_edge"],"vertices":64,
      "max_residual":1e-12})"));
  for (const char* suffix : {"vtp", "vtk", "svg", "geojson", "csv"})
    EXPECT_EQ(answer["files"][suffix], "/v1/results/" + id + "." + suffix);
  EXPECT_EQ(answer["files"].size(), 5u);
}

TEST_F(RoutesTest, the_same_request_at_the_same_time_is_traced_once) {
  std::promise<void> released;
  const auto release = released.get_future().share();
  std::atomic<int> entered = 0;
  engine = [&](const auto& system, const auto& request) {
    ++entered;
    release.wait();
    return test::draw_circles(system, request);
  };
  std::vector<std::future<std::string>> answers;
  const auto ask_for = [&](const json& request) {
    answers.push_back(std::async(std::launch::async, [&, request] { return post(request).body; }));
  };
  const auto wait_for = [&](int count) {
    for (int i = 0; i < 2000 && entered < count; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  json other = ball_request();
  other["levels"] = json::parse("[0.0004]");
  ask_for(ball_request());
  ask_for(other);
  wait_for(2);
  ask_for(ball_request());
  ask_for(ball_request());
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // they would enter now
  released.set_value();
  std::vector<std::string> bodies;
  for (auto& answer : answers) bodies.push_back(answer.get());
  EXPECT_EQ(entered, 2);
  EXPECT_EQ(json::parse(bodies[0])["curves"].size(), 3u);
  EXPECT_EQ(bodies[2], bodies[0]);
  EXPECT_EQ(bodies[3], bodies[0]);
  EXPECT_EQ(json::parse(bodies[1])["curves"].size(), 2u) << bodies[1];
}

class NotedThread : public Exchange {
 public:
  void answer(HttpResponse) override { answered.set_value(std::this_thread::get_id()); }
  void on_leave(std::function<void()>) override {}

  std::promise<std::thread::id> answered;
};

/// Zeros of expressions take long to find: the thread that serves clients does not look for them.
TEST_F(RoutesTest, expressions_are_read_by_another_thread) {
  const auto reader_of = [&](const json& shape, bool escaped = false) {
    json request = ball_request();
    request["scene"]["surfaces"][0]["shape"] = shape;
    std::string body = request.dump();
    if (escaped)
      for (std::size_t at; (at = body.find("expression")) != body.npos;)
        body.replace(at, 1, "\\u0065");
    const auto exchange = std::make_shared<NotedThread>();
    routes.serve({"POST", "/v1/contours", "application/json", body, false}, exchange);
    return exchange->answered.get_future().get();
  };
  const auto here = std::this_thread::get_id();
  EXPECT_EQ(reader_of({{"type", "sphere"}, {"radius", -1}}), here);
  const json bad = {{"expression", "x +"}, {"type", "expression"}};
  EXPECT_NE(reader_of(bad), here);
  EXPECT_NE(reader_of(bad, true), here);
}

/// With one thread, which is busy, the second waits for as long as the first runs.
TEST_F(RoutesTest, says_how_long_a_computation_waited) {
  Jobs one_thread{{1, 4}};
  Routes narrow{contours, store, one_thread};
  std::promise<void> released;
  const auto release = released.get_future().share();
  std::atomic<int> entered = 0;
  engine = [&](const auto& system, const auto& request) {
    if (++entered == 1) release.wait();
    return test::draw_circles(system, request);
  };
  json other = ball_request();
  other["levels"] = json::parse("[0.0004]");
  const auto waited = [&](const json& request) {
    const HttpResponse response =
        test::ask(narrow, {"POST", "/v1/contours", "application/json", request.dump(), false});
    const std::string timing = header(response, "Server-Timing");
    EXPECT_TRUE(timing.starts_with("queue;dur=")) << timing;
    return std::stod(timing.substr(10));
  };
  auto first = std::async(std::launch::async, [&] { return waited(ball_request()); });
  while (entered == 0) std::this_thread::yield();
  auto second = std::async(std::launch::async, [&] { return waited(other); });
  while (one_thread.waiting() == 0) std::this_thread::yield();
  constexpr double kPause = 20.0;  // ms
  std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(kPause));
  released.set_value();
  EXPECT_GE(first.get(), 0.0);
  EXPECT_GE(second.get(), kPause);
  EXPECT_EQ(header(post(ball_request()), "Server-Timing"), "");  // it is stored: nothing waited
}

TEST_F(RoutesTest, what_fails_fails_for_all_who_asked_and_can_be_asked_again) {
  std::promise<void> released;
  const auto release = released.get_future().share();
  engine = [&](const auto&, const auto&) -> solver::ContourResult {
    release.wait();
    throw ProblemError(make_problem(503, "not now"));
  };
  std::vector<std::future<int>> statuses;
  for (int i = 0; i < 3; ++i)
    statuses.push_back(std::async(std::launch::async, [&] { return post(ball_request()).status; }));
  released.set_value();
  for (auto& status : statuses) EXPECT_EQ(status.get(), 503);
  engine = test::draw_circles;
  EXPECT_EQ(post(ball_request()).status, 200);
}

TEST_F(RoutesTest, what_the_engine_lacks_is_a_fault_of_the_request) {
  engine = [](const auto&, const auto& request) {
    solver::ContourResult result;
    EXPECT_EQ(request.measure, solver::Measure::total);
    result.unsupported = "the total of moonlight";
    return result;
  };
  json request = ball_request();
  request["measure"] = "total";
  const HttpResponse response = post(request);
  EXPECT_EQ(response.status, 422);
  EXPECT_EQ(json::parse(response.body)["errors"], json::parse(R"([{"pointer":"/measure","detail":
                "the total of moonlight: not supported by this version"}])"));
  engine = test::draw_circles;
  EXPECT_EQ(post(request).status, 200);  // nothing was stored
}

TEST_F(RoutesTest, serves_what_it_stored) {
  const std::string body = post(ball_request()).body;
  const json answer = json::parse(body);
  const std::string place = "/v1/results/" + answer["id"].get<std::string>();
  EXPECT_EQ(ask("GET", place).body, body);
  EXPECT_EQ(ask("GET", place + "?x=1").body, body);
  for (const Format& format : formats()) {
    const HttpResponse file = ask("GET", answer["files"][format.suffix]);
    EXPECT_EQ(file.status, 200);
    EXPECT_EQ(file.content_type, format.media_type);
    EXPECT_EQ(header(file, "Content-Disposition"),
              "attachment; filename=" + answer["id"].get<std::string>() + "." + format.suffix);
    EXPECT_FALSE(file.body.empty());
    EXPECT_EQ(ask("HEAD", answer["files"][format.suffix]).status, 200);
  }
}

TEST_F(RoutesTest, computes_once) {
  const std::string first = post(ball_request()).body;
  EXPECT_EQ(post(ball_request()).body, first);
  json other_limits = ball_request();
  other_limits["limits"] = {{"time_ms", 10}};
  EXPECT_EQ(post(other_limits).body, first);
  EXPECT_EQ(runs, 1);
}

TEST_F(RoutesTest, writes_nothing_if_told_so) {
  json request = ball_request();
  request["store"] = false;
  const json answer = json::parse(post(request).body);
  EXPECT_EQ(answer["files"], json::object());
  EXPECT_EQ(answer["geojson"]["features"].size(), 3u);
  EXPECT_EQ(folder.entries(), 0u);
  EXPECT_EQ(ask("GET", "/v1/results/" + answer["id"].get<std::string>()).status, 404);
}

TEST_F(RoutesTest, a_result_cut_by_a_limit_never_answers_again) {
  engine = [](const auto& system, const auto& request) {
    auto result = test::draw_circles(system, request);
    result.complete = false;
    result.curves[0].closed = false;
    result.curves[0].ends = {solver::Ending::limit, solver::Ending::limit};
    result.warnings = {{"limit", "out of time"}};
    return result;
  };
  const json first = json::parse(post(ball_request()).body);
  const json second = json::parse(post(ball_request()).body);
  EXPECT_EQ(first["complete"], false);
  EXPECT_EQ(first["warnings"][0]["code"], "limit");
  EXPECT_EQ(first["curves"][0]["ends"], json::parse(R"(["limit","limit"])"));
  EXPECT_NE(first["id"], second["id"]);
  EXPECT_EQ(runs, 2);
  EXPECT_EQ(ask("GET", first["files"]["vtp"]).status, 200);
  engine = test::draw_circles;
  const json whole = json::parse(post(ball_request()).body);
  EXPECT_EQ(whole["complete"], true);
  EXPECT_NE(whole["id"], first["id"]);
}

TEST_F(RoutesTest, no_number_that_is_not_finite_leaves) {
  engine = [](const auto& system, const auto& request) {
    auto result = test::draw_circles(system, request);
    result.curves[1].vertices[5].gradient.x() = std::nan("");
    result.families[0].flux = geometry::kInfinity;
    return result;
  };
  const json answer = json::parse(post(ball_request()).body);
  EXPECT_EQ(answer["curves"].size(), 2u);
  EXPECT_EQ(answer["warnings"][0]["code"], "not_finite");
  EXPECT_TRUE(answer["families"][0]["flux"].is_null());
}

TEST_F(RoutesTest, names_faults_as_problem_json) {
  json request = ball_request();
  request["levels"] = {-1};
  test::surface(request)["shape"]["radius"] = -1;
  const HttpResponse response = post(request);
  EXPECT_EQ(response.status, 422);
  EXPECT_EQ(response.content_type, "application/problem+json");
  const json problem = json::parse(response.body);
  EXPECT_EQ(problem["type"], "about:blank");
  EXPECT_EQ(problem["status"], 422);
  EXPECT_EQ(problem["title"], "Unprocessable Content");
  EXPECT_TRUE(problem["detail"].is_string());
  ASSERT_EQ(problem["errors"].size(), 2u);
  EXPECT_EQ(problem["errors"][0]["pointer"], "/scene/surfaces/0/shape/radius");
  EXPECT_EQ(problem["errors"][1]["pointer"], "/levels/0");
  EXPECT_EQ(folder.entries(), 0u);
  EXPECT_EQ(runs, 0);
}

TEST_F(RoutesTest, refuses_what_is_not_served) {
  const std::tuple<const char*, std::string, int> cases[] = {
      {"GET", "//", 404},
      {"GET", "", 404},
      {"POST", "/", 405},
      {"GET", "/assets/", 404},
      {"GET", "/assets/none.js", 404},
      {"GET", "/assets/../etc/passwd", 404},
      {"DELETE", "/assets/none.js", 405},
      {"GET", "*", 404},
      {"GET", "/v1/contours/", 404},
      {"POST", "/nothing", 404},
      {"GET", "/v1/contours", 405},
      {"DELETE", "/v1/contours", 405},
      {"POST", "/healthz", 405},
      {"PUT", "/v1/results/" + std::string(64, 'a'), 405},
      {"BREW", "/v1/examples", 405},
      {"GET", "/v1/results/" + std::string(64, 'a'), 404},
      {"GET", "/v1/results/" + std::string(64, 'A'), 404},
      {"GET", "/v1/results/" + std::string(63, 'a'), 404},
      {"GET", "/v1/results/" + std::string(64, 'a') + ".vtp", 404},
      {"GET", "/v1/results/" + std::string(64, 'a') + ".exe", 404},
      {"GET", "/v1/results/..", 404},
      {"GET", "/v1/results/../../etc/passwd", 404},
      {"GET", "/v1/results/%2e%2e%2fetc%2fpasswd", 404},
      {"GET", "/v1/results/", 404},
      {"GET", "/v1/examples/", 404},
      {"GET", "/v1/examples/none", 404},
      {"GET", "/" + std::string(5000, 'a'), 414},
  };
  for (const auto& [method, target, status] : cases) {
    const HttpResponse response = ask(method, target);
    EXPECT_EQ(response.status, status) << method << " " << target;
    EXPECT_EQ(json::parse(response.body)["status"], status);
  }
  EXPECT_EQ(ask("GET", "/v1/contours").headers, (HttpHeaders{{"Allow", "POST, OPTIONS"}}));
}

TEST_F(RoutesTest, a_file_name_is_an_id_and_one_known_suffix) {
  const std::string id = json::parse(post(ball_request()).body)["id"];
  for (const char* suffix : {".exe", ".", ".vtp.vtk", ".VTP", ".record", "..vtp", ".vtp%00", "/x"})
    EXPECT_EQ(ask("GET", "/v1/results/" + id + suffix).status, 404) << suffix;
}

TEST_F(RoutesTest, wants_the_right_content_type) {
  const std::string body = ball_request().dump();
  for (const char* type :
       {"", "text/plain", "application/jsonx", "application/x-www-form-urlencoded",
        "multipart/form-data; boundary=x", ";application/json"})
    EXPECT_EQ(ask("POST", "/v1/contours", body, type).status, 415) << type;
  for (const char* type : {"application/json", "Application/JSON",
                           "application/json; charset=utf-8", "application/json ;x=y"})
    EXPECT_EQ(ask("POST", "/v1/contours", body, type).status, 200) << type;
}

TEST_F(RoutesTest, a_body_over_the_limit_is_413) {
  EXPECT_EQ(test::ask(routes, {"POST", "/v1/contours", "application/json", "", true}).status, 413);
}

TEST_F(RoutesTest, what_breaks_inside_stays_inside) {
  engine = [](const auto&, const auto&) -> solver::ContourResult {
    throw std::runtime_error("the secret of /etc");
  };
  testing::internal::CaptureStderr();
  const HttpResponse response = post(ball_request());
  EXPECT_NE(testing::internal::GetCapturedStderr().find("the secret"), std::string::npos);
  EXPECT_EQ(response.status, 500);
  EXPECT_EQ(response.body.find("secret"), std::string::npos);
  engine = [](const auto&, const auto&) -> solver::ContourResult { throw 7; };
  EXPECT_EQ(post(ball_request()).status, 500);
}

TEST_F(RoutesTest, every_example_is_a_good_request) {
  const json list = json::parse(ask("GET", "/v1/examples").body)["examples"];
  EXPECT_GE(list.size(), 2u);
  for (const json& example : list) {
    EXPECT_FALSE(example["title"].get<std::string>().empty());
    const HttpResponse body = ask("GET", "/v1/examples/" + example["name"].get<std::string>());
    EXPECT_EQ(body.status, 200);
    const HttpResponse answer = ask("POST", "/v1/contours", body.body);
    EXPECT_EQ(answer.status, 200) << example["name"] << answer.body;
  }
}

TEST_F(RoutesTest, tells_its_health_and_its_contract) {
  EXPECT_EQ(json::parse(ask("GET", "/healthz").body),
            json::parse(R"({"status":"ok","version":"0.1.0"})"));
  const json document = json::parse(ask("GET", "/openapi.json").body);
  EXPECT_EQ(document["openapi"], "3.1.0");
  EXPECT_EQ(document["info"]["version"], "0.1.0");
}

TEST_F(RoutesTest, stopping_ends_what_runs_and_refuses_more) {
  engine = [this](const auto& system, const auto& request) {
    jobs.interrupt();
    EXPECT_TRUE(*request.cancelled);
    return test::draw_circles(system, request);
  };
  EXPECT_EQ(post(ball_request()).status, 503);
  EXPECT_EQ(post(ball_request()).status, 503);
  EXPECT_EQ(runs, 1);
  EXPECT_EQ(folder.entries(), 0u);
}

}  // namespace
}  // namespace caustic::service
