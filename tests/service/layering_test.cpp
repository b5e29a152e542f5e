// The house's rules about includes: geometry <- solver <- service, and each big library behind one
// file.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

/// Every #include of the sources below a folder: file (from the top) → what it includes.
std::multimap<std::string, std::string> includes_below(const std::string& layer) {
  static const std::regex include(R"re(^\s*#include\s*[<"]([^>"]+)[>"])re");
  std::multimap<std::string, std::string> out;
  const fs::path top = ISOCAUSTIC_SOURCE;
  for (const auto& entry : fs::recursive_directory_iterator(top / layer)) {
    const std::string suffix = entry.path().extension();
    if (suffix != ".h" && suffix != ".cpp") continue;
    std::ifstream in(entry.path());
    std::smatch match;
    for (std::string line; std::getline(in, line);)
      if (std::regex_search(line, match, include))
        out.emplace(fs::relative(entry.path(), top).string(), match[1]);
  }
  return out;
}

TEST(Layering, nothing_includes_upward) {
  const std::pair<const char*, std::vector<std::string>> above[] = {
      {"geometry", {"solver/", "service/", "tests/", "nlohmann/", "vtk", "httplib"}},
      {"solver", {"service/", "tests/", "nlohmann/", "vtk", "httplib"}},
      {"service", {"tests/", "embree", "boost/"}}};
  for (const auto& [layer, forbidden] : above)
    for (const auto& [file, included] : includes_below(layer))
      for (const std::string& prefix : forbidden)
        EXPECT_FALSE(included.starts_with(prefix)) << file << " includes " << included;
}

TEST(Layering, each_big_library_is_behind_one_file) {
  const std::pair<const char*, const char*> owners[] = {{"vtk", "service/formats/vtk.cpp"},
                                                        {"httplib", "service/http/server.cpp"},
                                                        {"CLI/", "service/cli/command_line.cpp"}};
  for (const auto& [file, included] : includes_below("service"))
    for (const auto& [library, owner] : owners)
      EXPECT_TRUE(!included.starts_with(library) || file == owner)
          << file << " includes " << included;
}

}  // namespace
