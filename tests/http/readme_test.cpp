// What README.md tells the reader to type does what it says.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace caustic::test {
namespace {

/// The code block of this language that contains `word`, with the example's port replaced.
std::string code_block(const std::string& language, const std::string& word, int port) {
  const std::string text = read_file(ISOCAUSTIC_README), fence = "```" + language + "\n";
  for (auto at = text.find(fence); at != text.npos; at = text.find(fence, at + 1)) {
    const auto begin = at + fence.size();
    std::string block = text.substr(begin, text.find("```", begin) - begin);
    if (block.find(word) == block.npos) continue;
    const std::string example = "http://127.0.0.1:8080";
    const auto address = block.find(example);
    if (address == block.npos) continue;
    return block.replace(address, example.size(), "http://127.0.0.1:" + std::to_string(port));
  }
  return {};
}

class ReadmeTest : public testing::Test {
 protected:
  TemporaryFolder folder;
  ServerProcess server{folder.path() / "data"};
};

TEST_F(ReadmeTest, python_client) {
  const std::string script = code_block("python", "urllib", server.port());
  ASSERT_FALSE(script.empty());
  const auto run =
      run_command({"sh", "-c", "cd \"$0\" && exec python3 -", folder.path().string()}, script);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("isolux "), run.out.npos) << run.out;
  EXPECT_NE(run.out.find("caustic "), run.out.npos) << run.out;
  EXPECT_NE(run.out.find("vertices  closed"), run.out.npos) << run.out;
  EXPECT_NE(read_file(folder.path() / "curves.vtp").find("<VTKFile type=\"PolyData\""),
            std::string::npos);
}

TEST_F(ReadmeTest, curl_command) {
  const std::string script = code_block("sh", "curl -s", server.port());
  ASSERT_FALSE(script.empty());
  const auto run = run_command({"sh"}, script);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const auto answer = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_FALSE(answer.is_discarded()) << run.out;
  EXPECT_EQ(answer["complete"], true);
  EXPECT_GE(answer["curves"].size(), 6u);
}

TEST_F(ReadmeTest, curl_command_of_the_analysis) {
  const std::string script = code_block("sh", "/v1/analysis", server.port());
  ASSERT_FALSE(script.empty());
  const auto run = run_command({"sh"}, script);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const auto answer = nlohmann::json::parse(run.out, nullptr, false);
  ASSERT_FALSE(answer.is_discarded()) << run.out;
  EXPECT_EQ(answer["levels"].size(), 3u);
}

}  // namespace
}  // namespace caustic::test
