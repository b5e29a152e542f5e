// Run time against error: every method on every scene, as a table.
#include <sched.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>

#include "tests/bench/methods/truth.h"
#include "tests/bench/methods/verify.h"

namespace caustic::bench {
namespace {

// Short runs are repeated, at most so often or for so long, and the shortest counts.
constexpr int kRuns = 20;
constexpr double kSeconds = 1.0;
// Settings grow at most so fast that the next takes four times as long; a factor of ten, of
// photons, is to be paid by who asks for it.
constexpr double kGrowth = 4.0;

struct Options {
  std::vector<std::string> scenes, methods;
  std::string csv = "-", remark;
  double longest = 20.0;
  bool verify = false;
};

struct Run {
  Drawing drawing;
  double seconds = geometry::kInfinity;
  int runs = 0;
};

Run run(const Method& method, const Scene& scene, double setting) {
  Run best;
  for (double total = 0.0; best.runs < kRuns && total < kSeconds; ++best.runs) {
    const auto begin = std::chrono::steady_clock::now();
    best.drawing = method.draw(scene, setting);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    best.seconds = std::min(best.seconds, seconds);
    total += seconds;
  }
  return best;
}

std::size_t segments(const Drawing& drawing) {
  std::size_t count = 0;
  for (const auto& lines : drawing.levels)
    for (const auto& line : lines) count += std::max<std::size_t>(line.size(), 1) - 1;
  return count;
}

void write(std::ostream& out, const Scene& scene, const Method& method, double setting,
           const Run& run, const DrawingError& error) {
  char numbers[200];
  std::snprintf(numbers, sizeof numbers, "%g,%.6g,%d,%llu,%zu,%.3g,%.3g,%.3g,%.3g,%.4g,%.4g",
                setting, run.seconds, run.runs,
                static_cast<unsigned long long>(run.drawing.evaluations), segments(run.drawing),
                error.all.max, error.all.mean(), error.level_arcs.max, error.level_arcs.mean(),
                error.all.farthest.x(), error.all.farthest.y());
  out << scene.name << ",\"" << method.name << "\"," << numbers << ",\"" << run.drawing.remark
      << "\"\n"
      << std::flush;
}

bool wanted(const std::vector<std::string>& names, const std::string& name) {
  return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<Method> all_methods() {
  std::vector<Method> all;
  for (const auto& some :
       {our_methods(), chen_methods(), grid_methods(), photon_methods(), povray_methods()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

void compare(const Scene& scene, const Options& options, std::ostream& out) {
  std::map<solver::Measure, Truth> truths;
  for (const Method& method : all_methods()) {
    if (!wanted(options.methods, method.name) || (method.suits && !method.suits(scene))) continue;
    if (!method.missing.empty()) {
      std::cerr << method.name << ": left out, " << method.missing << '\n';
      continue;
    }
    if (!truths.count(method.measure))
      truths.emplace(method.measure, make_truth(scene, method.measure));
    for (const double setting : method.settings) {
      if (setting < 2.0 * scene.truth_chord) continue;  // it would be measured by itself
      const Run result = run(method, scene, setting);
      write(out, scene, method, setting, result,
            error_of(scene, truths.at(method.measure), result.drawing));
      if (kGrowth * result.seconds > options.longest) break;
    }
  }
}

// VTK's threads and other programs are kept to it too.
void keep_to_one_core() {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(sched_getcpu(), &one);
  if (sched_setaffinity(0, sizeof one, &one) != 0) std::cerr << "more than one core is used\n";
}

int answer(int argc, char** argv) {
  Options options;
  CLI::App app{"Run time against error of methods that draw level curves"};
  app.add_option("--scene", options.scenes, "only these")->check(CLI::IsMember(scene_names()));
  std::vector<std::string> names;
  for (const Method& method : all_methods()) names.push_back(method.name);
  app.add_option("--method", options.methods, "only these")->check(CLI::IsMember(names));
  app.add_option("--csv", options.csv, "where the table goes")->capture_default_str();
  app.add_option("--remark", options.remark, "first line of the table");
  app.add_option("--longest", options.longest, "seconds that one drawing may take, about")
      ->capture_default_str();
  app.add_flag("--verify", options.verify, "instead: how true the truth is");
  CLI11_PARSE(app, argc, argv);

  keep_to_one_core();
  std::ofstream file;
  if (options.csv != "-") file.open(options.csv);
  std::ostream& out = options.csv == "-" ? std::cout : file;
  if (!options.remark.empty()) out << "# " << options.remark << '\n';
  out << (options.verify ? kVerifyColumns
                         : "scene,method,setting,seconds,runs,evaluations,segments,max,mean,"
                           "max of level arcs,mean of level arcs,u of max,v of max,remark")
      << '\n';
  for (const std::string& name : scene_names()) {
    if (!wanted(options.scenes, name)) continue;
    const Scene scene = make_scene(name);
    options.verify ? verify(scene, out) : compare(scene, options, out);
  }
  return out.good() ? 0 : 1;
}

}  // namespace
}  // namespace caustic::bench

int main(int argc, char** argv) try {
  return caustic::bench::answer(argc, argv);
} catch (const std::exception& fault) {
  std::fprintf(stderr, "%s\n", fault.what());
  return 1;
}
