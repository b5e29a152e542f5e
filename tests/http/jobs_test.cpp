// Long work, and what operators see of it, over the wire.
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/support/http_client.h"
#include "tests/support/program.h"
#include "tests/support/requests.h"
#include "tests/support/temporary_folder.h"

namespace caustic::test {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

const std::string kAsync = "Content-Type: application/json\r\nPrefer: respond-async\r\n";

std::string post_bytes(const json& request, const std::string& headers) {
  const std::string body = request.dump();
  return post_head("/v1/contours",
                   headers + "Content-Length: " + std::to_string(body.size()) + "\r\n") +
         body;
}

class JobsOverHttp : public testing::Test {
 protected:
  HttpReply post_async(const json& request) {
    HttpConnection connection(server.port());
    connection.send(post_bytes(request, kAsync));
    return connection.receive();
  }
  json job(const std::string& location, const std::string& method = "GET") {
    const HttpReply reply = http_get(server.port(), location, method);
    EXPECT_EQ(reply.status, 200) << reply.body;
    return json::parse(reply.body);
  }
  template <typename Condition>
  json wait_for(const std::string& location, Condition holds) {
    json report = job(location);
    for (int i = 0; i < 6000 && !holds(report); ++i) {
      std::this_thread::sleep_for(milliseconds(5));
      report = job(location);
    }
    EXPECT_TRUE(holds(report)) << report;
    return report;
  }
  static bool ended(const json& report) {
    return report["status"] != "accepted" && report["status"] != "running";
  }

  TemporaryFolder folder;
  ServerProcess server{folder.path() / "data",
                       {"--threads", "1", "--workers", "1", "--queue", "4", "--grace", "0"}};
};

TEST_F(JobsOverHttp, run_are_asked_for_and_answer) {
  json request = ball_request();
  const HttpReply accepted = post_async(request);
  ASSERT_EQ(accepted.status, 202) << accepted.body;
  const std::string location = accepted.headers.at("location");
  EXPECT_EQ(location, "/v1/jobs/" + json::parse(accepted.body)["id"].get<std::string>());
  EXPECT_EQ(accepted.headers.at("preference-applied"), "respond-async");
  const json report = wait_for(location, ended);
  EXPECT_EQ(report["status"], "successful");
  EXPECT_EQ(report["progress"], 1.0);
  const HttpReply result = http_get(server.port(), report["result"]);
  EXPECT_EQ(result.status, 200);
  EXPECT_EQ(post_async(request).body, result.body);  // what is there already is the answer
  request["store"] = false;
  EXPECT_EQ(post_async(request).status, 200);  // what is stored nowhere is waited for
  EXPECT_EQ(post_async(json::object()).status, 422);
  EXPECT_EQ(http_get(server.port(), "/v1/jobs/" + std::string(64, '0')).status, 404);
  EXPECT_EQ(http_get(server.port(), "/v1/jobs/x/events").status, 404);
}

TEST_F(JobsOverHttp, are_joined_move_and_are_dismissed) {
  const HttpReply first = post_async(long_request()), second = post_async(long_request());
  ASSERT_EQ(first.status, 202);
  const std::string location = first.headers.at("location");
  EXPECT_EQ(second.headers.at("location"), location);
  wait_for(location, [](const json& report) { return report["progress"] > 0.0; });
  HttpConnection events(server.port());
  events.send("GET " + location + "/events HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(events.receive().headers.at("content-type"), "text/event-stream");
  // The one thread takes up what has come in its order: so this one joins before the next cancels.
  HttpConnection waits(server.port()), cancels(server.port());
  for (HttpConnection* known : {&waits, &cancels}) {
    known->send("GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n");
    EXPECT_EQ(known->receive().status, 200);
  }
  waits.send(post_bytes(long_request(), "Content-Type: application/json\r\n"));
  cancels.send("DELETE " + location + " HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(cancels.receive().status, 200);
  EXPECT_EQ(waits.receive().status, 503);
  EXPECT_EQ(wait_for(location, ended)["status"], "dismissed");
  const std::string stream = events.receive_rest();
  EXPECT_NE(stream.find("event: job\ndata: {\"id\":"), stream.npos) << stream;
  EXPECT_NE(stream.find("id: end\nevent: end\ndata: "), stream.npos) << stream;
  HttpConnection again(server.port());
  again.send("GET " + location + "/events HTTP/1.1\r\nHost: x\r\nLast-Event-ID: end\r\n\r\n");
  EXPECT_EQ(again.receive().status, 204);
  EXPECT_EQ(job(location, "DELETE")["status"], "dismissed");
}

TEST_F(JobsOverHttp, nobody_waits_nobody_works) {
  {
    HttpConnection leaves(server.port());
    leaves.send(post_bytes(long_request(), "Content-Type: application/json\r\n"));
    EXPECT_TRUE(is_computing(server.port()));
  }
  // With one worker this would else be answered after a minute.
  EXPECT_EQ(http_post(server.port(), "/v1/contours", ball_request().dump()).status, 200);
}

TEST_F(JobsOverHttp, a_full_queue_says_so_and_others_are_served) {
  std::vector<std::string> locations;
  HttpReply reply;
  for (int i = 0; i < 10; ++i) {
    reply = post_async(long_request(i));
    if (reply.status == 202) locations.push_back(reply.headers.at("location"));
  }
  EXPECT_GE(locations.size(), 4u);
  EXPECT_LE(locations.size(), 5u);
  EXPECT_EQ(reply.status, 503);
  EXPECT_EQ(reply.headers.at("retry-after"), "1");
  EXPECT_EQ(http_get(server.port(), "/healthz").status, 200);
  EXPECT_EQ(http_get(server.port(), "/readyz").status, 503);
  const std::string metrics = http_get(server.port(), "/metrics").body;
  EXPECT_NE(metrics.find("isocaustic_queue_length 4\n"), metrics.npos) << metrics;
  for (const std::string& location : locations) job(location, "DELETE");
  EXPECT_EQ(http_post(server.port(), "/v1/contours", ball_request().dump()).status, 200);
  EXPECT_EQ(http_get(server.port(), "/readyz").status, 200);
}

TEST_F(JobsOverHttp, that_were_interrupted_say_so_after_a_restart) {
  for (const int signal : {SIGKILL, SIGTERM}) {
    ServerProcess other(folder.path() / "other", {"--grace", "0"});
    HttpConnection connection(other.port());
    connection.send(post_bytes(long_request(signal), kAsync));
    const std::string location = connection.receive().headers.at("location");
    const ServerProcess beside(folder.path() / "other");
    const auto seen = [&](const ServerProcess& by) {
      return json::parse(http_get(by.port(), location).body);
    };
    EXPECT_FALSE(ended(seen(beside)));
    EXPECT_EQ(http_get(beside.port(), location, "DELETE").status, 409);
    other.stop(signal);
    const ServerProcess after(folder.path() / "other");
    for (const ServerProcess* one : {&beside, &after}) {
      EXPECT_EQ(seen(*one)["status"], "failed");
      EXPECT_NE(seen(*one)["problem"]["detail"].get<std::string>().find("interrupted"),
                std::string::npos);
    }
  }
}

/// Its state and its end, but not how far it is, are known to all servers of the folder.
TEST_F(JobsOverHttp, are_followed_from_another_server) {
  const ServerProcess one(folder.path() / "shared"), two(folder.path() / "shared");
  json request = long_request();
  request["limits"]["time_ms"] = 500;
  HttpConnection posts(one.port());
  posts.send(post_bytes(request, kAsync));
  const std::string location = posts.receive().headers.at("location");
  const HttpReply seen = http_get(two.port(), location);
  EXPECT_EQ(seen.status, 200);
  EXPECT_EQ(json::parse(seen.body)["result"], nullptr);
  HttpConnection events(two.port());
  events.send("GET " + location + "/events HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(events.receive().status, 200);
  EXPECT_NE(events.receive_rest().find("event: end\ndata: "), std::string::npos);
  const json report = json::parse(http_get(two.port(), location).body);
  EXPECT_EQ(report["status"], "successful");
  EXPECT_EQ(http_get(two.port(), report["result"]).status, 200);
  EXPECT_EQ(http_get(two.port(), location, "DELETE").status, 200);  // nothing is left to cancel
}

TEST_F(JobsOverHttp, what_runs_is_finished_before_the_end) {
  ServerProcess other(folder.path() / "other", {"--grace", "30000"});
  json request = long_request();
  request["limits"]["time_ms"] = 300;
  HttpReply reply;
  std::thread client([&] { reply = http_post(other.port(), "/v1/contours", request.dump()); });
  EXPECT_TRUE(is_computing(other.port()));
  EXPECT_EQ(other.stop(SIGTERM), 0);
  client.join();
  EXPECT_EQ(reply.status, 200);
}

TEST_F(JobsOverHttp, a_token_and_the_environment) {
  std::ofstream(folder.path() / "token") << "s3cret\n";
  setenv("ISOCAUSTIC_TOKEN_FILE", (folder.path() / "token").c_str(), 1);
  setenv("ISOCAUSTIC_CORS_ORIGIN", "https://a.example,https://b.example", 1);
  const ServerProcess guarded(folder.path() / "guarded");
  unsetenv("ISOCAUSTIC_TOKEN_FILE");
  unsetenv("ISOCAUSTIC_CORS_ORIGIN");
  EXPECT_EQ(http_get(guarded.port(), "/healthz").status, 200);
  EXPECT_EQ(http_post(guarded.port(), "/v1/contours", ball_request().dump()).status, 401);
  HttpConnection connection(guarded.port());
  connection.send(post_bytes(ball_request(),
                             "Content-Type: application/json\r\n"
                             "Authorization: Bearer s3cret\r\n"
                             "Origin: https://b.example\r\n"));
  const HttpReply reply = connection.receive();
  EXPECT_EQ(reply.status, 200);
  EXPECT_EQ(reply.headers.at("access-control-allow-origin"), "https://b.example");
  EXPECT_EQ(run_program({"serve", "--token-file", "/dev/null"}).exit_code, 2);
  const std::string help = run_program({"serve", "--help"}).out;
  for (const char* option : {"--token-file", "ISOCAUSTIC_TOKEN_FILE", "--store-size", "--queue"})
    EXPECT_NE(help.find(option), help.npos) << option;
}

TEST_F(JobsOverHttp, metrics_are_what_prometheus_reads) {
  http_post(server.port(), "/v1/contours", ball_request().dump());
  http_post(server.port(), "/v1/contours", ball_request().dump());
  const HttpReply reply = http_get(server.port(), "/metrics");
  EXPECT_EQ(reply.headers.at("content-type"), "text/plain; version=0.0.4; charset=utf-8");
  for (const char* line :
       {"isocaustic_requests_total{route=\"/v1/contours\",status=\"200\"} 2\n",
        "isocaustic_cache_hits_total 1\n", "isocaustic_cache_misses_total 1\n",
        "isocaustic_curves_total{ending=\"closed\"} ", "isocaustic_evaluations_total "})
    EXPECT_NE(reply.body.find(line), reply.body.npos) << line << reply.body;
}

TEST_F(JobsOverHttp, results_are_kept_by_caches) {
  const json answer =
      json::parse(http_post(server.port(), "/v1/contours", ball_request().dump()).body);
  for (const std::string& target : {"/v1/results/" + answer["id"].get<std::string>(),
                                    answer["files"]["vtp"].get<std::string>()}) {
    const HttpReply first = http_get(server.port(), target);
    EXPECT_NE(first.headers.at("cache-control").find("immutable"), std::string::npos);
    HttpConnection connection(server.port());
    connection.send("GET " + target + " HTTP/1.1\r\nHost: x\r\nIf-None-Match: " +
                    first.headers.at("etag") + "\r\n\r\n");
    const HttpReply second = connection.receive();
    EXPECT_EQ(second.status, 304);
    EXPECT_EQ(second.headers.at("etag"), first.headers.at("etag"));
    connection.send("GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n");
    EXPECT_EQ(connection.receive().headers.at("cache-control"), "no-store");
  }
}

/// A client that leaves in the middle of a download takes nothing with it.
TEST_F(JobsOverHttp, downloads_that_are_broken_off) {
  json request = ball_request();
  request["tolerance"] = {{"chord", 1e-6}};
  const json answer = json::parse(http_post(server.port(), "/v1/contours", request.dump()).body);
  const HttpReply whole = http_get(server.port(), answer["files"]["csv"]);
  ASSERT_GT(whole.body.size(), 500'000u);
  for (int i = 0; i < 20; ++i) {
    HttpConnection connection(server.port());
    connection.send("GET " + answer["files"]["csv"].get<std::string>() +
                    " HTTP/1.1\r\nHost: x\r\n\r\n");
  }
  EXPECT_EQ(http_get(server.port(), answer["files"]["csv"]).body, whole.body);
}

}  // namespace
}  // namespace caustic::test
