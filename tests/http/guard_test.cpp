// What the HTTP library lets through, one test for each: the attack is refused or harmless, memory
// stays, others are served meanwhile. (Heads and chunks in all their variants:
// tests/service/request_reader_test.cpp; time: reactor_test.cpp.)
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/support/http_client.h"
#include "tests/support/program.h"
#include "tests/support/requests.h"
#include "tests/support/temporary_folder.h"

namespace caustic::test {
namespace {

using nlohmann::json;

constexpr long kMostGrowth = 32 * 1024;  // KiB

class GuardTest : public testing::Test {
 protected:
  int port() const { return server.port(); }
  std::string log_file() const { return (folder.path() / "log").string(); }
  int status_of(const std::string& bytes) const {
    HttpConnection connection(port());
    connection.send(bytes);
    return connection.receive().status;
  }
  void SetUp() override {
    ASSERT_EQ(http_get(port(), "/healthz").status, 200);
    memory = server.peak_memory();
  }
  void TearDown() override {
    if (stopped) return;
    EXPECT_TRUE(server.running());
    EXPECT_EQ(http_get(port(), "/healthz").status, 200);
    EXPECT_LT(server.peak_memory() - memory, kMostGrowth);
  }

  TemporaryFolder folder;
  ServerProcess server{folder.path() / "data",
                       {"--log", log_file(), "--threads", "1", "--max-body", "1048576"}};
  long memory = 0;
  bool stopped = false;
};

TEST_F(GuardTest, a_chunked_body_without_end) {
  HttpConnection connection(port());
  connection.send(post_head("/v1/contours",
                            "Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n"));
  const std::string chunk = "100000\r\n" + std::string(0x100000, 'x') + "\r\n";
  for (int i = 0; i < 200 && connection.send(chunk); ++i) {
    if (i % 50 != 0) continue;
    EXPECT_EQ(http_get(port(), "/healthz").status, 200);
  }
  const int status = connection.receive().status;
  EXPECT_TRUE(status == 413 || status == 0) << status;
}

TEST_F(GuardTest, a_body_that_unpacks_to_more) {
  EXPECT_EQ(status_of(post_head("/v1/contours",
                                "Content-Type: application/json\r\nContent-Encoding: gzip\r\n"
                                "Content-Length: 2\r\n") +
                      "\x1f\x8b"),
            415);
}

TEST_F(GuardTest, a_line_without_end_and_headers_without_number) {
  for (const std::string beginning : {"", "GET /healthz HTTP/1.1\r\nHost: x\r\nA: "}) {
    HttpConnection connection(port());
    connection.send(beginning);
    const std::string more(1 << 20, 'a');
    for (int i = 0; i < 64 && connection.send(more); ++i) {
    }
    const int status = connection.receive().status;
    EXPECT_TRUE(status == 414 || status == 431 || status == 0) << status;
  }
  HttpConnection connection(port());
  connection.send("GET /healthz HTTP/1.1\r\nHost: x\r\n");
  std::string headers;
  for (int i = 0; i < 1000; ++i) headers += "A" + std::to_string(i) + ": b\r\n";
  for (int i = 0; i < 200 && connection.send(headers); ++i) {
  }
  const int status = connection.receive().status;
  EXPECT_TRUE(status == 431 || status == 0) << status;
}

/// Answers come whole: a few ranges are ignored, as they may be, and hundreds are refused.
TEST_F(GuardTest, ranges_by_the_hundred) {
  const std::string get = "GET /openapi.json HTTP/1.1\r\nHost: x\r\nRange: bytes=0-";
  const std::size_t whole = http_get(port(), "/openapi.json").body.size();
  std::string ranges;
  for (int i = 0; i < 600; ++i) ranges += ",0-";
  for (int i = 0; i < 10; ++i) {
    HttpConnection connection(port());
    connection.send(get + ",0-,0-\r\n\r\n");
    const HttpReply reply = connection.receive();
    EXPECT_EQ(reply.status, 200);
    EXPECT_EQ(reply.body.size(), whole);
    connection.send(get + ranges + "\r\n\r\n");
    EXPECT_EQ(connection.receive().status, 416);
    EXPECT_TRUE(connection.closed_by_server());
  }
}

TEST_F(GuardTest, long_paths) {
  for (const std::size_t length : {999u, 1001u, 4000u, 4200u, 100'000u}) {
    const int status = status_of("GET /v1/results/" + std::string(length - 12, '%') +
                                 " HTTP/1.1\r\nHost: x\r\n\r\n");
    EXPECT_EQ(status, length < 1000 ? 404 : 414) << length;
  }
}

TEST_F(GuardTest, requests_in_requests) {
  const std::string hidden = "GET /v1/examples HTTP/1.1\r\nHost: x\r\n\r\n";
  const std::string length = "Content-Length: " + std::to_string(hidden.size()) + "\r\n";
  for (const std::string& head : std::vector<std::string>{
           "GET /healthz HTTP/1.1\r\nHost: x\r\n" + length + "\r\n",
           "DELETE /healthz HTTP/1.1\r\nHost: x\r\n" + length + "\r\n",
           "GET /healthz HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: chunked\r\n\r\n",
           post_head("/healthz", length + "Transfer-Encoding: chunked\r\n"),
           post_head("/healthz", length + length),
           post_head("/healthz", "Transfer-Encoding: chunked\r\nTransfer-Encoding: x\r\n"),
           post_head("/healthz", "Content-Length : 0\r\n"),
           post_head("/healthz", "A: b\r\n " + length)}) {
    HttpConnection connection(port());
    connection.send(head + hidden);
    EXPECT_EQ(connection.receive().status, 400) << head;
    EXPECT_TRUE(connection.closed_by_server()) << head;  // the hidden one is not answered
  }
}

TEST_F(GuardTest, a_client_cannot_say_who_it_is_nor_write_the_log) {
  HttpConnection connection(port());
  connection.send(
      "GET /healthz HTTP/1.1\r\nHost: x\r\nREMOTE_ADDR: 10.1.2.3\r\nX-Request-Id: a%0d%0aX-Evil: "
      "b\r\n\r\n");
  const HttpReply reply = connection.receive();
  EXPECT_EQ(reply.status, 200);
  EXPECT_EQ(reply.headers.count("x-evil"), 0u);
  EXPECT_EQ(reply.headers.at("x-request-id").find('%'), std::string::npos);
  connection.send("GET /v1/\"quote HTTP/1.1\r\nHost: x\r\nX-Request-Id: from-the-proxy.7\r\n\r\n");
  EXPECT_EQ(connection.receive().headers.at("x-request-id"), "from-the-proxy.7");
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nHost: x\r\nX: \x01\r\n\r\n"), 400);
  EXPECT_EQ(server.stop(SIGTERM), 0);
  stopped = true;
  std::istringstream log(read_file(log_file()));
  std::vector<json> lines;
  for (std::string line; std::getline(log, line);) lines.push_back(json::parse(line));
  ASSERT_EQ(lines.size(), 4u);
  for (const json& line : lines) EXPECT_EQ(line["peer"], "127.0.0.1");
  EXPECT_EQ(lines[1]["id"], reply.headers.at("x-request-id"));
  EXPECT_EQ(lines[2]["id"], "from-the-proxy.7");
  EXPECT_EQ(lines[2]["target"], "/v1/\"quote");
  EXPECT_EQ(lines[3]["status"], 400);
}

TEST_F(GuardTest, no_coding_but_gzip_and_only_where_it_pays) {
  const json answer = json::parse(http_post(port(), "/v1/contours", ball_request().dump()).body);
  const std::string target = answer["files"]["geojson"];
  const HttpReply plain = http_get(port(), target);
  const auto asked = [&](const std::string& codings, const std::string& path) {
    HttpConnection connection(port());
    connection.send("GET " + path + " HTTP/1.1\r\nHost: x\r\nAccept-Encoding: " + codings +
                    "\r\n\r\n");
    return connection.receive();
  };
  for (const char* codings : {"br", "zstd", "gzip;q=0", "identity", "*;q=0.0", "nonsense;;,"}) {
    const HttpReply reply = asked(codings, target);
    EXPECT_EQ(reply.headers.count("content-encoding"), 0u) << codings;
    EXPECT_EQ(reply.headers.at("vary"), "Accept-Encoding");
    EXPECT_EQ(reply.body, plain.body);
  }
  for (const char* codings : {"gzip", "br, gzip;q=0.5", "*", "deflate , gzip"}) {
    const HttpReply reply = asked(codings, target);
    EXPECT_EQ(reply.headers.at("content-encoding"), "gzip") << codings;
    EXPECT_NE(reply.headers.at("etag"), plain.headers.at("etag"));
    std::ofstream(folder.path() / "body.gz", std::ios::binary) << reply.body;
    EXPECT_EQ(run_command({"gzip", "-dc", (folder.path() / "body.gz").string()}).out, plain.body);
  }
  EXPECT_EQ(asked("gzip", answer["files"]["vtp"]).headers.count("content-encoding"), 0u);
  EXPECT_EQ(asked("gzip", "/healthz").headers.count("content-encoding"), 0u);
}

/// More clients of every slow kind than there are threads, which is one.
TEST_F(GuardTest, clients_that_wait_drip_or_do_not_read) {
  std::vector<std::unique_ptr<HttpConnection>> others;
  const char* beginnings[] = {
      "", "GET /healthz HT", "GET /openapi.json HTTP/1.1\r\nHost: x\r\n\r\n",
      "POST /v1/contours HTTP/1.1\r\nHost: x\r\nContent-Length: 9\r\n\r\n{"};
  for (int i = 0; i < 200; ++i) {
    others.push_back(std::make_unique<HttpConnection>(port()));
    others.back()->send(beginnings[i % 4]);
  }
  for (int i = 0; i < 20; ++i) EXPECT_EQ(http_get(port(), "/healthz").status, 200);
  others[1]->send("TP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(others[1]->receive().status, 200);
  others[3]->send("       }");
  EXPECT_EQ(others[3]->receive().status, 415);
}

TEST_F(GuardTest, requests_that_come_together_are_answered_in_turn) {
  HttpConnection connection(port());
  std::string bytes;
  for (int i = 0; i < 20; ++i)
    bytes += "GET /healthz HTTP/1.1\r\nHost: x\r\nX-Request-Id: r" + std::to_string(i) + "\r\n\r\n";
  json request = ball_request();
  request["store"] = false;
  const std::string body = request.dump();
  bytes += post_head("/v1/contours",
                     "X-Request-Id: r20\r\nContent-Type: application/json\r\n"
                     "Content-Length: " +
                         std::to_string(body.size()) + "\r\n") +
           body + "GET /v1/examples HTTP/1.1\r\nHost: x\r\nX-Request-Id: r21\r\n\r\n";
  connection.send(bytes);
  for (int i = 0; i < 22; ++i) {
    const HttpReply reply = connection.receive();
    EXPECT_EQ(reply.status, 200);
    EXPECT_EQ(reply.headers.at("x-request-id"), "r" + std::to_string(i));
  }
}

TEST_F(GuardTest, who_asks_first_is_told_to_go_on) {
  HttpConnection connection(port());
  const std::string body = irradiance_request().dump();
  const std::string head = "Expect: 100-continue\r\nContent-Type: application/json\r\n";
  connection.send(post_head("/v1/irradiance",
                            head + "Content-Length: " + std::to_string(body.size()) + "\r\n"));
  connection.send(body);
  EXPECT_EQ(connection.receive().status, 200);
  EXPECT_EQ(status_of(post_head("/v1/irradiance", head + "Content-Length: 2000000\r\n")), 413);
}

}  // namespace
}  // namespace caustic::test
