// The embedded page: what a browser needs to load it and to keep it.
#include <gtest/gtest.h>

#include <regex>

#include "service/http/caching.h"
#include "service/http/page_response.h"
#include "tests/support/ask.h"

namespace caustic::service {
namespace {

HttpResponse get(const PageFile& file, HttpHeaders headers = {}) {
  HttpRequest request{"GET", std::string(file.path), "", "", false};
  request.headers = std::move(headers);
  return page_response(request, file);
}

TEST(Page, is_the_same_compressed_or_not) {
  for (const PageFile& file : page_files()) {
    const HttpResponse plain = get(file), packed = get(file, {{"accept-encoding", "br, gzip"}});
    EXPECT_EQ(plain.body.size(), file.size);
    EXPECT_EQ(gunzip(packed.body, file.size), plain.body) << file.path;
    EXPECT_EQ(test::header(plain, "Content-Encoding"), "");
    EXPECT_EQ(test::header(packed, "Content-Encoding"), "gzip");
    EXPECT_EQ(test::header(packed, "Vary"), "Accept-Encoding");
    EXPECT_EQ(plain.content_type, file.content_type);
    EXPECT_NE(test::header(plain, "ETag"), test::header(packed, "ETag"));
  }
}

TEST(Page, is_kept_by_browsers_as_long_as_it_is_true) {
  for (const PageFile& file : page_files()) {
    const std::string kept = test::header(get(file), "Cache-Control");
    if (file.path.starts_with("/assets/"))
      EXPECT_NE(kept.find("immutable"), kept.npos) << file.path;
    else
      EXPECT_EQ(kept, "no-cache") << file.path;
    for (const char* coding : {"", "gzip"}) {
      const std::string tag = test::header(get(file, {{"accept-encoding", coding}}), "ETag");
      const HttpResponse again = get(file, {{"accept-encoding", coding}, {"if-none-match", tag}});
      EXPECT_EQ(again.status, 304);
      EXPECT_EQ(again.body, "");
      EXPECT_EQ(test::header(again, "ETag"), tag);
    }
    EXPECT_EQ(get(file, {{"if-none-match", "\"other\""}}).status, 200);
  }
}

/// Else the browser would refuse part of it, by the policy that is sent along.
TEST(Page, has_nothing_inline_and_refers_to_what_is_there) {
  for (const PageFile& file : page_files()) {
    const HttpResponse response = get(file);
    EXPECT_NE(test::header(response, "Content-Security-Policy").find("script-src 'self';"),
              std::string::npos);
    if (!file.content_type.starts_with("text/html")) continue;
    const std::string& html = response.body;
    EXPECT_FALSE(std::regex_search(html, std::regex("<style|style=|<script>|[ ]on[a-z]+=")));
    const std::regex link("(?:src|href)=\"([^\"]*)\"");
    for (std::sregex_iterator at(html.begin(), html.end(), link), end; at != end; ++at) {
      const std::string target = (*at)[1];
      if (target.starts_with('#')) continue;
      EXPECT_TRUE(target == "/openapi.json" || find_page_file(target)) << target;
    }
  }
}

}  // namespace
}  // namespace caustic::service
