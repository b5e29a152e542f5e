#include "service/api/json_text.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>

#include "service/api/problem.h"

namespace caustic::service {
namespace {

Problem problem_of(const std::string& text) {
  try {
    parse_json(text);
  } catch (const ProblemError& error) {
    return error.problem();
  }
  return {};
}

TEST(JsonText, refuses_what_is_not_json) {
  for (const char* text : {"",
                           " ",
                           "{",
                           "[1,]",
                           "{\"a\":}",
                           "NaN",
                           "[NaN]",
                           "[Infinity]",
                           "[-Infinity]",
                           "[1e999]",
                           "[-1e999]",
                           "{} x",
                           "{}{}",
                           "[01]",
                           "[1.]",
                           "[+1]",
                           "'a'",
                           "{a:1}",
                           "[1] // no",
                           "\"\xff\"",
                           "{\"a\":1,\"a\":2}",
                           "{\"a\":{\"b\":1,\"b\":1}}",
                           "[1",
                           "nul",
                           "\xff\xfe{}",
                           "\"\n\""}) {
    EXPECT_EQ(problem_of(text).status, 400) << text;
  }
  EXPECT_EQ(problem_of(std::string("{}\0", 3)).status, 400);
}

TEST(JsonText, says_what_is_wrong_and_where) {
  EXPECT_NE(problem_of("[1e999]").detail.find("1e999"), std::string::npos);
  EXPECT_NE(problem_of("[1,NaN]").detail.find("byte 4"), std::string::npos);
  EXPECT_NE(problem_of(R"({"a":1,"a":2})").detail.find("duplicate key"), std::string::npos);
  // Half a character in the excerpt does not break the answer.
  std::string long_key = "{\"";
  for (int i = 0; i < 99; ++i) long_key += 'x';
  long_key += "\xc3\xa9\":1";
  EXPECT_EQ(problem_of(long_key + "," + long_key.substr(1) + "}").status, 400);
  EXPECT_EQ(problem_of("[" + long_key.substr(1)).status, 400);
}

TEST(JsonText, limits_depth_and_values) {
  EXPECT_NO_THROW(parse_json(std::string(64, '[') + std::string(64, ']')));
  EXPECT_EQ(problem_of(std::string(65, '[') + std::string(65, ']')).status, 400);
  EXPECT_EQ(problem_of(std::string(200'000, '[')).status, 400);
  std::string objects;
  for (int i = 0; i < 200'000; ++i) objects += "{\"a\":";
  EXPECT_EQ(problem_of(objects).status, 400);
  std::string zeros = "[0";
  for (int i = 0; i < kMaxJsonValues; ++i) zeros += ",0";
  EXPECT_EQ(problem_of(zeros + "]").status, 400);
  EXPECT_EQ(problem_of(std::string(8 << 20, '\0')).status, 400);
}

TEST(JsonText, takes_json_in_all_its_forms) {
  EXPECT_EQ(parse_json("\xef\xbb\xbf{}"), nlohmann::json::object());  // byte order mark
  EXPECT_EQ(parse_json(" [1, 1.0, 1e0, 10E-1] "), nlohmann::json::parse("[1.0,1.0,1.0,1.0]"));
  EXPECT_EQ(parse_json(R"("A<&é😀")"), "A<&é😀");
  EXPECT_EQ(parse_json("[1e-999]")[0], 0.0);
}

TEST(JsonText, writes_equal_values_as_equal_text) {
  EXPECT_EQ(write_json(parse_json(R"( {"b": [1.0, -0.0, -0, 1e3], "a": {"y": null, "x": true}} )")),
            R"({"a":{"x":true,"y":null},"b":[1,0,0,1000]})");
  EXPECT_EQ(write_json(nlohmann::json{{"k\"<", "v\\é\x01"}}), "{\"k\\\"<\":\"v\\\\é\\u0001\"}");
}

TEST(JsonText, writes_the_shortest_number_that_reads_back) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 10'000; ++i) {
    const double value = std::bit_cast<double>(random());
    if (!std::isfinite(value)) continue;
    std::string text;
    append_number(text, value);
    EXPECT_EQ(std::strtod(text.c_str(), nullptr), value);
    EXPECT_EQ(write_json(parse_json(text)), text == "-0" ? "0" : text);
  }
  std::string text;
  append_number(text, 0.1);
  EXPECT_EQ(text, "0.1");
}

}  // namespace
}  // namespace caustic::service
