// The stress program: random scenes, skewed to trouble, each answer checked. See README.md.
#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <map>

#include "tests/stress/random_scene.h"
#include "tests/stress/report.h"
#include "tests/stress/scene_run.h"

namespace {

using namespace caustic::stress;
using nlohmann::json;

int check_file(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot read " + path);
  const json outcome = outcome_of(json::parse(in), 1, 0, Thoroughness::every_check(), [] {});
  std::cout << outcome.dump(1) << '\n';
  return outcome.contains("refused") || !outcome["findings"].empty();
}

int run(std::uint64_t seed, const BatchPlan& plan, const Thoroughness& how,
        const std::string& folder) {
  Report report(std::cout, folder);
  std::map<std::uint64_t, json> requests;  // of scenes under way
  std::uint64_t done = 0;
  run_batches(
      plan, [&](std::uint64_t k, const Voice& voice) { run_scene(seed, k, how, voice); },
      [&](std::uint64_t k, const json& line) {
        json& request = requests[k];
        if (line.contains("request")) request = line["request"];
        if (line.contains("traced")) request["traced"] = true;
        if (!line.contains("died") && !line.contains("done")) return;
        const bool traced = request.is_object() && request.erase("traced") > 0;
        if (line.contains("done"))
          report.add(k, line, request);
        else
          report.died(k, line["died"].get<std::string>() + (traced ? ", while checked" : ""),
                      request);
        requests.erase(k);
        if (++done % 500 == 0) std::cerr << done << " of " << plan.count << std::endl;
      });
  report.print();
  return report.failed() > 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Random scenes, skewed to trouble: every answer is checked.");
  std::uint64_t seed = 1, only = 0;
  BatchPlan plan{0, 10'000};
  std::string folder, file;
  bool print = false, quick = false;
  app.add_option("--scenes", plan.count, "how many scenes")->capture_default_str();
  app.add_option("--first", plan.first, "number of the first")->capture_default_str();
  app.add_option("--seed", seed, "of all of them")->capture_default_str();
  app.add_option("--jobs", plan.jobs, "processes at once")->capture_default_str();
  app.add_option("--minutes", plan.minutes, "begin no further scenes after so long");
  app.add_option("--keep", folder, "folder for the requests that fail");
  const auto* one = app.add_option("--only", only, "this scene alone");
  app.add_option("--request", file, "a request to check, instead of random ones");
  app.add_flag("--quick", quick, "the same scenes, less of each, as in the suite");
  app.add_flag("--print", print, "with --only: print the request, trace nothing");
  CLI11_PARSE(app, argc, argv);
  if (!file.empty()) return check_file(file);
  if (*one) plan.first = only, plan.count = 1;
  if (*one && print) {
    std::cout << random_request(seed, only).dump(1) << '\n';
    return 0;
  }
  return run(seed, plan, quick ? Thoroughness::quick() : Thoroughness::full(), folder);
}
