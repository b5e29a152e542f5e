#include "service/http/front.h"
#include "service/page/page_files.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <thread>

#include "service/http/caching.h"
#include "tests/support/ask.h"

namespace caustic::service {
namespace {

using test::header;

class FrontTest : public testing::Test {
 protected:
  HttpResponse ask(const std::string& method, const std::string& target, HttpHeaders headers = {}) {
    Front front(
        [](HttpRequest, const std::shared_ptr<Exchange>& exchange) {
          exchange->answer({200, "text/plain", "reached", {}});
        },
        options, metrics, nullptr);
    HttpRequest request{method, target, "", "", false};
    request.headers = std::move(headers);
    const auto exchange = std::make_shared<test::WaitingExchange>();
    front(std::move(request), exchange);
    return exchange->wait();
  }
  FrontOptions options;
  Metrics metrics;
};

TEST_F(FrontTest, gives_every_answer_an_id) {
  const HttpResponse first = ask("GET", "/healthz"), second = ask("GET", "/healthz");
  EXPECT_FALSE(header(first, "X-Request-Id").empty());
  EXPECT_NE(header(first, "X-Request-Id"), header(second, "X-Request-Id"));
  EXPECT_EQ(header(ask("GET", "/", {{"x-request-id", "abc-1.2_3"}}), "X-Request-Id"), "abc-1.2_3");
  for (const std::string& bad : {std::string("a b"), std::string("a\"b"), std::string(65, 'a')})
    EXPECT_NE(header(ask("GET", "/", {{"x-request-id", bad}}), "X-Request-Id"), bad);
  EXPECT_EQ(header(first, "Access-Control-Allow-Origin"), "");
}

TEST_F(FrontTest, a_token_protects_everything_but_health) {
  options.token = "secret";
  EXPECT_EQ(ask("GET", "/healthz").status, 200);
  EXPECT_EQ(ask("GET", "/readyz?x").status, 200);
  // The page asks for the token, so it is there without one.
  for (const PageFile& file : page_files())
    EXPECT_EQ(ask("GET", std::string(file.path)).status, 200) << file.path;
  for (const char* target :
       {"/metrics", "/v1/examples", "/openapi.json", "/assets/", "/healthz/../metrics"})
    EXPECT_EQ(ask("GET", target).status, 401) << target;
  EXPECT_EQ(header(ask("GET", "/metrics"), "WWW-Authenticate"), "Bearer");
  for (const char* shown : {"Bearer secret ", "Bearer secre", "bearer secret", "secret", "Bearer ",
                            "Bearer secrets", "Basic secret"})
    EXPECT_EQ(ask("GET", "/metrics", {{"authorization", shown}}).status, 401) << shown;
  EXPECT_EQ(ask("GET", "/metrics", {{"authorization", "Bearer secret"}}).status, 200);
}

TEST_F(FrontTest, only_pages_of_the_list_may_ask) {
  options.origins = {"https://a.example", "http://localhost:5173"};
  const HttpResponse good = ask("GET", "/v1/examples", {{"origin", "http://localhost:5173"}});
  EXPECT_EQ(header(good, "Access-Control-Allow-Origin"), "http://localhost:5173");
  EXPECT_EQ(header(good, "Vary"), "Origin");
  for (const char* origin : {"https://b.example", "https://a.example.evil", "null", "*"})
    EXPECT_EQ(
        header(ask("GET", "/v1/examples", {{"origin", origin}}), "Access-Control-Allow-Origin"),
        "");
  const HttpResponse preflight = ask("OPTIONS", "/v1/contours", {{"origin", "https://a.example"}});
  EXPECT_EQ(preflight.status, 204);
  EXPECT_EQ(header(preflight, "Allow"), "POST, OPTIONS");
  EXPECT_EQ(header(preflight, "Access-Control-Allow-Methods"), "POST, OPTIONS");
  EXPECT_NE(header(preflight, "Access-Control-Allow-Headers").find("Content-Type"),
            std::string::npos);
  EXPECT_EQ(header(ask("OPTIONS", "/v1/contours", {{"origin", "https://b.example"}}),
                   "Access-Control-Allow-Methods"),
            "");
  EXPECT_EQ(ask("OPTIONS", "/nothing", {{"origin", "https://a.example"}}).body, "reached");
}

TEST_F(FrontTest, says_which_methods_a_path_takes) {
  for (const auto& [method, pattern] : Routes::all()) {
    std::string path = pattern;
    if (const auto hole = path.find("{}"); hole != path.npos) path.replace(hole, 2, "x");
    const HttpResponse response = ask("OPTIONS", path);
    EXPECT_EQ(response.status, 204) << path;
    EXPECT_NE(header(response, "Allow").find(method), std::string::npos) << path;
    EXPECT_EQ(header(response, "Access-Control-Allow-Methods"), "");
  }
  EXPECT_EQ(header(ask("OPTIONS", "/v1/jobs/x"), "Allow"), "GET, HEAD, DELETE, OPTIONS");
  EXPECT_EQ(ask("OPTIONS", "/nothing").body, "reached");
  options.token = "secret";
  EXPECT_EQ(ask("OPTIONS", "/v1/contours").status, 401);
  options.origins = {"https://a.example"};
  EXPECT_EQ(ask("OPTIONS", "/v1/contours", {{"origin", "https://a.example"}}).status, 204);
}

TEST_F(FrontTest, counts_answers_by_route_not_by_path) {
  ask("GET", "/v1/results/" + std::string(64, 'a'));
  ask("GET", "/v1/results/" + std::string(64, 'b') + ".vtp");
  ask("GET", "/whatever\"\n");
  const std::string text = metrics.text({{"isocaustic_queue_length", "Help.", 3}});
  for (const char* line :
       {"# TYPE isocaustic_requests_total counter\n",
        "isocaustic_requests_total{route=\"/v1/results/{}\",status=\"200\"} 2\n",
        "isocaustic_requests_total{route=\"other\",status=\"200\"} 1\n",
        "# TYPE isocaustic_request_seconds histogram\n",
        "isocaustic_request_seconds_bucket{le=\"+Inf\"} 3\n",
        "isocaustic_request_seconds_count 3\n",
        "# HELP isocaustic_queue_length Help.\n# TYPE isocaustic_queue_length gauge\n"
        "isocaustic_queue_length 3\n"})
    EXPECT_NE(text.find(line), text.npos) << line << text;
}

TEST(LogLines, do_not_wait_for_who_does_not_read) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const Descriptor reader(ends[0]);
  {
    LogLines log{Descriptor(ends[1])};
    const std::string line(1000, 'x');
    for (int i = 0; i < 5000; ++i) log.write(line);  // 5 MB into a pipe of 64 KiB
  }
  std::string bytes(1 << 20, '\0');
  const ssize_t count = read(reader.get(), bytes.data(), bytes.size());
  ASSERT_GT(count, 1000);
  EXPECT_EQ(bytes.substr(0, 1001), std::string(1000, 'x') + "\n");
}

TEST(LogLines, come_whole_and_in_turn) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  std::string bytes;
  std::thread reader([&] {
    const Descriptor end(ends[0]);
    char some[4096];
    for (ssize_t n; (n = read(end.get(), some, sizeof some)) > 0;)
      bytes.append(some, static_cast<std::size_t>(n));
  });
  {
    LogLines log{Descriptor(ends[1])};
    for (int i = 0; i < 100; ++i) log.write(std::to_string(i));
  }
  reader.join();
  std::string expected;
  for (int i = 0; i < 100; ++i) expected += std::to_string(i) + "\n";
  EXPECT_EQ(bytes, expected);
}

TEST(Caching, tags_are_compared_weakly) {
  HttpRequest request;
  const auto has = [&](const std::string& asked) {
    request.headers = {{"if-none-match", asked}};
    return has_tag(request, "abc");
  };
  for (const char* asked : {"\"abc\"", "W/\"abc\"", "*", "\"x\", \"abc\"", "\"abc-gzip\""})
    EXPECT_TRUE(has(asked)) << asked;
  for (const char* asked : {"", "abc", "\"abcd\"", "\"ab\"", "W/", "\"x\",\"*\"", ",,,"})
    EXPECT_FALSE(has(asked)) << asked;
  HttpResponse answer{200, "application/json", "{}", {}};
  EXPECT_EQ(immutable(request, "abc", answer).status, 200);
  has("\"abc\"");
  const HttpResponse same = immutable(request, "abc", answer);
  EXPECT_EQ(same.status, 304);
  EXPECT_EQ(same.body, "");
  EXPECT_EQ(header(same, "ETag"), "\"abc\"");
  EXPECT_NE(header(same, "Cache-Control").find("immutable"), std::string::npos);
}

}  // namespace
}  // namespace caustic::service
