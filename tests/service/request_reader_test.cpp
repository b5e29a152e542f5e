#include "service/http/request_reader.h"

#include <gtest/gtest.h>

namespace caustic::service {
namespace {

constexpr std::size_t kMaxBody = 1000;

/// Status of the refusal, 0 if the request is sound, -1 if more is needed.
int status_of(const std::string& bytes) {
  RequestReader reader(kMaxBody);
  reader.feed(bytes);
  const auto request = reader.next();
  if (!request) return -1;
  EXPECT_EQ(request->refusal.has_value(), !reader.keep_alive() || request->refusal.has_value());
  return request->refusal ? request->refusal->status : 0;
}

std::string get(const std::string& headers) {
  return "GET /x HTTP/1.1\r\nHost: x\r\n" + headers + "\r\n";
}
std::string post(const std::string& headers, const std::string& body) {
  return "POST /x HTTP/1.1\r\nHost: x\r\n" + headers + "\r\n" + body;
}

/// So many more ranges.
std::string ranges(std::size_t count) {
  std::string out;
  for (std::size_t i = 0; i < count; ++i) out += ",0-";
  return out;
}

TEST(RequestReader, reads_a_request_however_it_is_cut) {
  const std::string bytes =
      post("Content-Type:  application/json \r\nTransfer-Encoding: chunked\r\n",
           "4;x=y\r\nabcd\r\n1\r\ne\r\n0\r\nTrailer: t\r\n\r\n");
  for (std::size_t step : {1u, 2u, 3u, 7u, 1000u}) {
    RequestReader reader(kMaxBody);
    std::optional<HttpRequest> request;
    for (std::size_t at = 0; at < bytes.size(); at += step) {
      ASSERT_FALSE(request);
      reader.feed(bytes.substr(at, step));
      request = reader.next();
    }
    ASSERT_TRUE(request);
    EXPECT_FALSE(request->refusal);
    EXPECT_EQ(request->method, "POST");
    EXPECT_EQ(request->target, "/x");
    EXPECT_EQ(request->content_type, "application/json");
    EXPECT_EQ(request->body, "abcde");
    EXPECT_EQ(request->header("host"), "x");
    EXPECT_TRUE(reader.keep_alive());
    EXPECT_TRUE(reader.idle());
    EXPECT_EQ(reader.held(), RequestReader(kMaxBody).held());
  }
}

TEST(RequestReader, reads_what_comes_together_one_by_one) {
  RequestReader reader(kMaxBody);
  reader.feed(get("") + post("Content-Length: 3\r\n", "abc") + "\r\n" +
              get("Connection: close\r\n"));
  EXPECT_EQ(reader.next()->method, "GET");
  EXPECT_EQ(reader.next()->body, "abc");
  EXPECT_TRUE(reader.has_more());
  EXPECT_EQ(reader.next()->body, "");
  EXPECT_FALSE(reader.keep_alive());
  EXPECT_FALSE(reader.next());
}

TEST(RequestReader, skips_one_empty_line_before_a_request_however_it_comes) {
  for (const std::string& empty : {std::string("\r\n"), std::string("\r\n\r\n")})
    for (std::size_t step : {1u, 2u, 1000u}) {
      const std::string bytes = empty + get("");
      RequestReader reader(kMaxBody);
      std::optional<HttpRequest> request;
      for (std::size_t at = 0; at < bytes.size() && !request; at += step) {
        reader.feed(bytes.substr(at, step));
        request = reader.next();
      }
      ASSERT_TRUE(request);
      EXPECT_EQ(request->refusal.has_value(), empty.size() > 2) << step;
    }
}

TEST(RequestReader, refuses_heads_that_two_could_read_in_two_ways) {
  const std::string body = "Content-Length: 2\r\n";
  const std::pair<std::string, int> cases[] = {
      {"GET /x HTTP/1.1\n\n", 400},
      {"GET /x HTTP/1.1\r\nHost: x\r\nA: b\n\r\n\r\n", 400},
      {"GET /x HTTP/1.1\r\nHost: x\r\nA: b\rc\r\n\r\n", 400},
      {"\r\n\r\n", 400},
      {"GET\r\n\r\n", 400},
      {"GET /x\r\n\r\n", 400},
      {"GET  /x HTTP/1.1\r\nHost: x\r\n\r\n", 400},
      {"GET /x  HTTP/1.1\r\nHost: x\r\n\r\n", 400},
      {"GET /x y HTTP/1.1\r\nHost: x\r\n\r\n", 400},
      {"GET /\xc3\xa9 HTTP/1.1\r\nHost: x\r\n\r\n", 400},
      {"get /x HTTP/1.1\r\nHost: x\r\n\r\n", 400},
      {"G(T /x HTTP/1.1\r\nHost: x\r\n\r\n", 400},
      {"GET /x HTTP/2.0\r\n\r\n", 505},
      {"GET /x HTTQ/1.1\r\n\r\n", 400},
      {get("No colon\r\n"), 400},
      {get(": x\r\n"), 400},
      {get("A : x\r\n"), 400},
      {get(" A: x\r\n"), 400},
      {get("A: x\r\n folded\r\n"), 400},
      {get("A: x\r\n\tfolded\r\n"), 400},
      {get(std::string("A: x\0y\r\n", 8)), 400},
      {get("A: x\x7fy\r\n"), 400},
      {get("A(b): x\r\n"), 400},
      {get("Host: b\r\n"), 400},
      {"GET /x HTTP/1.1\r\n\r\n", 400},
      {get(body) + "ab", 400},
      {get("Transfer-Encoding: chunked\r\n"), 400},
      {post(body + body, "ab"), 400},
      {post("Content-Length: 2\r\nContent-Length: 3\r\n", "ab"), 400},
      {post(body + "Transfer-Encoding: chunked\r\n", "0\r\n\r\n"), 400},
      {post("Transfer-Encoding: gzip, chunked\r\n", "0\r\n\r\n"), 400},
      {post("Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n", "0\r\n\r\n"), 400},
      {post("Transfer-Encoding: identity\r\n", ""), 400},
      {"POST /x HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n", 400},
      {post("Content-Length: -2\r\n", "ab"), 400},
      {post("Content-Length: +2\r\n", "ab"), 400},
      {post("Content-Length: 2, 2\r\n", "ab"), 400},
      {post("Content-Length: 0x2\r\n", "ab"), 400},
      {post("Content-Length: \r\n", "ab"), 400},
      {post("Content-Length: 99999999999999999999\r\n", "ab"), 413},
      {get("Range: bytes=0-\r\nRange: bytes=1-\r\n"), 400},
      {get("Range: bytes=0-" + ranges(kMaxRanges) + "\r\n"), 416},
      {post("Content-Encoding: gzip\r\n" + body, "ab"), 415},
      {post("Content-Encoding: br\r\n" + body, "ab"), 415},
      {post("Expect: something\r\n" + body, "ab"), 417},
      {post("Expect: 100-continue\r\nContent-Length: 1001\r\n", ""), 413},
  };
  for (const auto& [bytes, status] : cases) EXPECT_EQ(status_of(bytes), status) << bytes;
  EXPECT_EQ(status_of(post("Content-Encoding: identity\r\n" + body, "ab")), 0);
  EXPECT_EQ(status_of(get("Range: bytes=0-" + ranges(kMaxRanges - 1) + "\r\n")), 0);
  EXPECT_EQ(status_of(get("Content-Length: 0\r\n")), 0);
  EXPECT_EQ(status_of(get("A: \xc3\xa9\r\n")), 0);
}

TEST(RequestReader, refuses_chunks_that_two_could_read_in_two_ways) {
  const std::pair<std::string, int> cases[] = {
      {"2\nab\r\n0\r\n\r\n", 400},
      {"2\r\nab", -1},
      {"2\r\nabc\r\n0\r\n\r\n", 400},
      {"g\r\n", 400},
      {"\r\n", 400},
      {" 2\r\nab\r\n", 400},
      {"2 \r\nab\r\n", 400},
      {"-2\r\nab\r\n", 400},
      {"0x2\r\nab\r\n", 400},
      {"fffffffffffffffff\r\n", 400},
      {"2;" + std::string(300, 'x') + "\r\nab\r\n", 400},
      {std::string("2;\0\r\nab\r\n", 9), 400},
      {"0\r\n" + std::string(5000, 't'), 431},
      {"0\r\nA: b\nC: d\r\n\r\n", 400},
      {"0\r\nA: b\r\n\r\n", 0},
  };
  for (const auto& [bytes, status] : cases)
    EXPECT_EQ(status_of(post("Transfer-Encoding: chunked\r\n", bytes)), status) << bytes;
}

TEST(RequestReader, holds_no_more_of_a_head_than_the_limit) {
  EXPECT_EQ(status_of("GET /" + std::string(kMaxTargetBytes + 100, 'a')), 414);
  EXPECT_EQ(status_of("GET /" + std::string(kMaxTargetBytes, 'a') + " HTTP/1.1\r\nHost: x\r\n\r\n"),
            414);
  EXPECT_EQ(status_of("GET / HTTP/1.1\r\nHost: x\r\nA: " + std::string(kMaxHeadBytes, 'a')), 431);
  std::string many;
  for (std::size_t i = 1; i < kMaxHeaders; ++i) many += "A: b\r\n";
  EXPECT_EQ(status_of(get(many)), 0);
  EXPECT_EQ(status_of(get(many + "A: b\r\n")), 431);
  RequestReader reader(kMaxBody);
  std::optional<HttpRequest> request;
  std::size_t fed = 0;
  for (; !request; fed += 1000) {
    reader.feed(std::string(1000, 'A'));
    request = reader.next();
  }
  EXPECT_LT(fed, 10'000u);
  reader.feed(std::string(100'000, 'A'));
  EXPECT_FALSE(reader.next());
}

TEST(RequestReader, keeps_no_more_of_a_body_than_the_limit) {
  for (const bool chunked : {false, true}) {
    RequestReader reader(kMaxBody);
    const std::size_t size = 1u << 20;
    reader.feed(
        post(chunked ? "Transfer-Encoding: chunked\r\n" : "Content-Length: 1048576\r\n", ""));
    if (chunked) reader.feed("100000\r\n");
    std::optional<HttpRequest> request;
    for (std::size_t sent = 0; sent < size; sent += 4096) {
      reader.feed(std::string(4096, 'x'));
      request = reader.next();
      EXPECT_LT(reader.held(), 20'000u);
    }
    if (chunked) {
      reader.feed("\r\n0\r\n\r\n");
      request = reader.next();
    }
    ASSERT_TRUE(request);
    EXPECT_TRUE(request->body_too_large);
    EXPECT_TRUE(request->body.empty());
    EXPECT_TRUE(reader.keep_alive());  // its end is known, so it is of use still
  }
}

TEST(RequestReader, a_body_without_end_is_refused) {
  RequestReader reader(kMaxBody);
  reader.feed(post("Transfer-Encoding: chunked\r\n", ""));
  const std::string chunk = "100000\r\n" + std::string(1u << 20, 'x') + "\r\n";
  std::optional<HttpRequest> request;
  for (int i = 0; i < 100 && !request; ++i) {
    reader.feed(chunk);
    request = reader.next();
  }
  ASSERT_TRUE(request && request->refusal);
  EXPECT_EQ(request->refusal->status, 413);
  EXPECT_EQ(status_of(post("Content-Length: 1000000000\r\n", "")), 413);
}

TEST(RequestReader, holds_nothing_once_it_is_reset) {
  RequestReader reader(1u << 20);
  reader.feed(post("Content-Length: 600000\r\n", std::string(400'000, 'x')));
  EXPECT_FALSE(reader.next());
  EXPECT_GE(reader.held(), 400'000u);
  reader.reset();
  EXPECT_EQ(reader.held(), RequestReader(1).held());
  reader.feed(get(""));
  EXPECT_EQ(reader.next()->method, "GET");
}

TEST(RequestReader, leaves_out_names_that_a_gateway_would_take_for_others) {
  RequestReader reader(kMaxBody);
  reader.feed(get("REMOTE_ADDR: 10.0.0.1\r\nContent_Length: 5\r\nA: %0d%0aB: c\r\n"));
  const auto request = reader.next();
  ASSERT_TRUE(request);
  ASSERT_EQ(request->headers.size(), 2u);  // and Host
  EXPECT_EQ(request->header("a"), "%0d%0aB: c");  // as sent
}

TEST(RequestReader, says_when_the_client_waits_to_be_told_to_go_on) {
  RequestReader reader(kMaxBody);
  reader.feed(post("Expect: 100-continue\r\nContent-Length: 2\r\n", ""));
  EXPECT_FALSE(reader.next());
  EXPECT_TRUE(reader.take_expectation());
  EXPECT_FALSE(reader.take_expectation());
  reader.feed("ab");
  EXPECT_EQ(reader.next()->body, "ab");
}

TEST(RequestReader, http_1_0_ends_unless_told_otherwise) {
  for (const auto& [head, keeps] :
       {std::pair{"GET / HTTP/1.0\r\n\r\n", false},
        {"GET / HTTP/1.0\r\nConnection: Keep-Alive\r\n\r\n", true},
        {"GET / HTTP/1.1\r\nHost: x\r\n\r\n", true},
        {"GET / HTTP/1.1\r\nHost: x\r\nConnection: x, Close\r\n\r\n", false}}) {
    RequestReader reader(kMaxBody);
    reader.feed(head);
    EXPECT_FALSE(reader.next()->refusal) << head;
    EXPECT_EQ(reader.keep_alive(), keeps) << head;
  }
}

}  // namespace
}  // namespace caustic::service
