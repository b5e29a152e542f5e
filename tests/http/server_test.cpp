// The server against clients that are wrong, rude or unlucky.
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/support/http_client.h"
#include "tests/support/program.h"
#include "tests/support/requests.h"
#include "tests/support/temporary_folder.h"

namespace caustic::test {
namespace {

using nlohmann::json;

const std::string kJson = "Content-Type: application/json\r\n";

std::string chunked(const std::string& body, std::size_t size) {
  std::string out;
  char head[32];
  for (std::size_t at = 0; at < body.size(); at += size) {
    const std::string chunk = body.substr(at, size);
    std::snprintf(head, sizeof head, "%zx\r\n", chunk.size());
    out += head + chunk + "\r\n";
  }
  return out + "0\r\n\r\n";
}

class ServerTest : public testing::Test {
 protected:
  int port() const { return server.port(); }
  HttpReply post(const std::string& body) { return http_post(port(), "/v1/contours", body); }
  /// The server is still there, and nothing was stored.
  void TearDown() override {
    EXPECT_TRUE(server.running());
    EXPECT_EQ(http_get(port(), "/healthz").status, 200);
  }
  bool nothing_stored() const { return std::filesystem::is_empty(folder.path() / "data"); }

  TemporaryFolder folder;
  ServerProcess server{folder.path() / "data", {"--max-body", "100000"}};
};

TEST_F(ServerTest, says_where_it_listens) {
  EXPECT_EQ(server.first_line(), "listening on http://127.0.0.1:" + std::to_string(port()));
}

TEST_F(ServerTest, answers_questions_by_numbers_and_stores_nothing) {
  const HttpReply paths = http_post(port(), "/v1/paths", path_request().dump());
  EXPECT_EQ(paths.status, 200);
  EXPECT_EQ(json::parse(paths.body)["paths"].size(), 1u);
  const HttpReply irradiance = http_post(port(), "/v1/irradiance", irradiance_request().dump());
  EXPECT_EQ(irradiance.status, 200);
  EXPECT_EQ(json::parse(irradiance.body)["points"].size(), 2u);
  const HttpReply analysis = http_post(port(), "/v1/analysis", analysis_request().dump());
  EXPECT_EQ(analysis.status, 200);
  EXPECT_EQ(json::parse(analysis.body)["levels"].size(), 2u);
  EXPECT_EQ(http_post(port(), "/v1/paths", "{}").status, 422);
  EXPECT_EQ(http_post(port(), "/v1/irradiance", "{}", "text/plain").status, 415);
  EXPECT_EQ(http_get(port(), "/v1/paths").status, 405);
  EXPECT_TRUE(nothing_stored());
}

TEST_F(ServerTest, answers_bad_input_with_problems) {
  EXPECT_EQ(post("").status, 400);
  EXPECT_EQ(post("{\"scene\":NaN}").status, 400);
  EXPECT_EQ(post("{\"scene\":1e999}").status, 400);
  EXPECT_EQ(post(ball_request().dump() + "x").status, 400);
  EXPECT_EQ(post(std::string("\0\0\0", 3)).status, 400);
  EXPECT_EQ(post(std::string(90'000, '[')).status, 400);
  EXPECT_EQ(post("{}").status, 422);
  EXPECT_EQ(http_post(port(), "/v1/contours", "{}", "text/plain").status, 415);
  EXPECT_EQ(http_post(port(), "/v1/nothing", "{}").status, 404);
  EXPECT_EQ(http_get(port(), "/v1/contours").status, 405);
  EXPECT_EQ(http_get(port(), "/v1/contours").headers.at("allow"), "POST, OPTIONS");
  EXPECT_EQ(http_get(port(), "/v1/contours", "OPTIONS").status, 204);
  EXPECT_EQ(http_get(port(), "/v1/nothing", "OPTIONS").status, 404);
  for (const char* method : {"PUT", "PATCH", "DELETE", "TRACE"})
    EXPECT_EQ(http_get(port(), "/v1/contours", method).status, 405) << method;
  const HttpReply reply = post("{");
  EXPECT_EQ(reply.headers.at("content-type"), "application/problem+json");
  EXPECT_EQ(json::parse(reply.body)["status"], 400);
  EXPECT_TRUE(nothing_stored());
}

TEST_F(ServerTest, a_depth_bomb_is_only_bad_json) {
  const ServerProcess roomy(folder.path() / "roomy");
  EXPECT_EQ(http_post(roomy.port(), "/v1/contours", std::string(200'000, '[')).status, 400);
  EXPECT_EQ(http_post(roomy.port(), "/v1/contours", std::string(8 << 20, '\0')).status, 400);
  EXPECT_EQ(http_post(roomy.port(), "/v1/contours", std::string(8 << 20, '0')).status, 400);
  std::string wide = "[[]";
  while (wide.size() + 10 < 8 << 20) wide += ",[]";
  EXPECT_EQ(http_post(roomy.port(), "/v1/contours", wide + "]").status, 400);
  EXPECT_EQ(http_get(roomy.port(), "/healthz").status, 200);
}

TEST_F(ServerTest, bodies_over_the_limit_are_413) {
  const std::string big(200'000, ' ');
  EXPECT_EQ(post(big).status, 413);
  HttpConnection connection(port());
  connection.send(post_head("/v1/contours", kJson + "Transfer-Encoding: chunked\r\n") +
                  chunked(big, 1000));
  EXPECT_EQ(connection.receive().status, 413);
  connection.send(post_head("/v1/contours", kJson + "Transfer-Encoding: chunked\r\n") +
                  chunked(ball_request().dump(), 7));
  EXPECT_EQ(connection.receive().status, 200);  // the connection is of use still
}

TEST_F(ServerTest, a_body_left_over_is_not_the_next_request) {
  HttpConnection connection(port());
  const std::string smuggled = "GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n";
  for (const auto& [target, status] : {std::pair("/v1/nothing", 404), {"/healthz", 405}}) {
    connection.send(
        post_head(target, "Content-Length: " + std::to_string(smuggled.size()) + "\r\n") +
        smuggled);
    EXPECT_EQ(connection.receive().status, status);
  }
  connection.send("GET /v1/examples HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_NE(connection.receive().body.find("examples"), std::string::npos);
}

TEST_F(ServerTest, lengths_that_lie) {
  {
    HttpConnection connection(port());  // promises more than it sends, and leaves
    connection.send(post_head("/v1/contours", kJson + "Content-Length: 1000\r\n") + "{}");
  }
  HttpConnection connection(port());
  connection.send(post_head("/v1/contours", kJson + "Content-Length: 2\r\n") + "{}garbage\r\n\r\n");
  EXPECT_EQ(connection.receive().status, 422);
  const std::pair<const char*, int> lengths[] = {
      {"-1", 400}, {"99999999999999999999999", 413}, {"abc", 400}, {"", 400}, {"1e3", 400}};
  for (const auto& [length, status] : lengths) {
    HttpConnection other(port());
    other.send(post_head("/v1/contours", kJson + "Content-Length: " + length + "\r\n") + "{}");
    EXPECT_EQ(other.receive().status, status) << length;
  }
  for (const std::string& doubled :
       {std::string("Content-Length: 2\r\nContent-Length: 3\r\n"),
        std::string("Content-Length: 2\r\nTransfer-Encoding: chunked\r\n"),
        std::string("Transfer-Encoding: gzip, chunked\r\n")}) {
    HttpConnection other(port());
    other.send(post_head("/v1/contours", kJson + doubled) + "{}");
    EXPECT_EQ(other.receive().status, 400) << doubled;
    EXPECT_TRUE(other.closed_by_server());
  }
  HttpConnection no_length(port());
  no_length.send(post_head("/v1/contours", kJson));
  EXPECT_EQ(no_length.receive().status, 400);
  EXPECT_TRUE(nothing_stored());
}

TEST_F(ServerTest, forms_and_compressed_bodies_are_no_way_in) {
  const std::string form =
      "--x\r\nContent-Disposition: form-data; name=\"a\"\r\n\r\n1\r\n--x--\r\n";
  const HttpReply reply =
      http_post(port(), "/v1/contours", form, "multipart/form-data; boundary=x");
  EXPECT_EQ(reply.status, 415);
  EXPECT_EQ(http_post(port(), "/v1/contours", form, "multipart/form-data").status, 415);
  EXPECT_EQ(http_post(port(), "/v1/contours", "a=b", "application/x-www-form-urlencoded").status,
            415);
  for (const char* coding : {"gzip", "br", "zstd", "nonsense"}) {
    HttpConnection connection(port());
    connection.send(post_head("/v1/contours",
                              kJson + "Content-Encoding: " + coding + "\r\nContent-Length: 2\r\n") +
                    "{}");
    const HttpReply coded = connection.receive();
    EXPECT_EQ(coded.status, 415) << coding;
    EXPECT_EQ(coded.headers.count("exception_what"), 0u);
  }
}

TEST_F(ServerTest, paths_lead_nowhere_else) {
  const std::string id(64, 'a');
  const std::vector<std::string> targets{"/../../etc/passwd",
                                         "/v1/results/../../../etc/passwd",
                                         "/v1/results/%2e%2e",
                                         "//healthz",
                                         "/healthz/",
                                         "/healthz%00",
                                         "/v1/results/" + id + ".vtp/..",
                                         "/v1/results/" + id,
                                         "http://x/healthz",
                                         "/%68ealthz"};
  for (const std::string& target : targets) {
    EXPECT_EQ(http_get(port(), target).status, 404) << target;
  }
  for (const std::size_t length : {2'000u, 8'000u, 20'000u}) {
    const HttpReply reply = http_get(port(), "/" + std::string(length, 'a'));
    EXPECT_EQ(reply.status, 414) << length;
    EXPECT_EQ(http_post(port(), "/" + std::string(length, 'a'), "{}").status, 414) << length;
  }
}

TEST_F(ServerTest, odd_heads) {
  const std::pair<std::string, int> heads[] = {
      {"\r\n\r\n", 400},
      {"GET\r\n\r\n", 400},
      {"GET / HTTP/9.9\r\n\r\n", 505},
      {"GET  /healthz  HTTP/1.1\r\nHost: x\r\n\r\n", 400},
      {"GET /healthz HTTP/1.1\r\nHost: x\r\n: x\r\n\r\n", 400},
      {"GET /healthz HTTP/1.1\r\nHost: x\r\nRange: bytes=9-1\r\n\r\n", 200},
      {std::string(9'000, 'A') + "\r\n\r\n", 400},
      {std::string("\xff\xfe\0\x01\r\n\r\n", 8), 400}};
  for (const auto& [head, status] : heads) {
    HttpConnection connection(port());
    connection.send(head);
    EXPECT_EQ(connection.receive().status, status) << head.substr(0, 40);
  }
}

TEST_F(ServerTest, a_connection_takes_many_requests) {
  HttpConnection connection(port());
  for (int i = 0; i < 300; ++i) {
    connection.send("GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n");
    ASSERT_EQ(connection.receive().status, 200);
  }
}

TEST_F(ServerTest, stops_when_asked) {
  for (const int signal : {SIGTERM, SIGINT}) {
    ServerProcess other(folder.path() / "other");
    EXPECT_EQ(http_get(other.port(), "/healthz").status, 200);
    EXPECT_EQ(other.stop(signal), 0);
    ServerProcess hasty(folder.path() / "other");  // may not listen yet
    EXPECT_EQ(hasty.stop(signal), 0);
  }
}

/// It would wait for an hour.
TEST_F(ServerTest, does_not_wait_for_idle_connections) {
  ServerProcess other(folder.path() / "other", {"--grace", "3600000"});
  HttpConnection silent(other.port()), idle(other.port());
  idle.send("GET /healthz HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(idle.receive().status, 200);
  EXPECT_EQ(other.stop(SIGTERM), 0);
  EXPECT_TRUE(idle.closed_by_server());
}

TEST_F(ServerTest, stops_in_the_middle_of_work) {
  ServerProcess other(folder.path() / "other", {"--grace", "100"});
  const HttpConnection idle(other.port());
  HttpReply reply;
  std::thread client(
      [&] { reply = http_post(other.port(), "/v1/contours", long_request().dump()); });
  EXPECT_TRUE(is_computing(other.port()));
  EXPECT_EQ(other.stop(SIGTERM), 0);
  client.join();
  EXPECT_EQ(reply.status, 503);
}

TEST_F(ServerTest, a_full_disk_is_507_and_leaves_nothing) {
  const ServerProcess full(folder.path() / "full", {}, 500);
  const HttpReply reply = http_post(full.port(), "/v1/contours", ball_request().dump());
  EXPECT_EQ(reply.status, 507);
  EXPECT_EQ(json::parse(reply.body)["status"], 507);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path() / "full"));
  EXPECT_EQ(http_get(full.port(), "/healthz").status, 200);
}

TEST_F(ServerTest, two_servers_share_a_folder) {
  const ServerProcess one(folder.path() / "shared"), two(folder.path() / "shared");
  const HttpReply first = http_post(one.port(), "/v1/contours", ball_request().dump());
  EXPECT_EQ(http_post(two.port(), "/v1/contours", ball_request().dump()).body, first.body);
}

}  // namespace
}  // namespace caustic::test
