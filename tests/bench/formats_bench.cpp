// Writing the file formats, for a request of about 1,500 vertices and one of about 10,000.
#include <benchmark/benchmark.h>

#include <nlohmann/json.hpp>

#include "service/api/answer_json.h"
#include "service/formats/format.h"
#include "service/results/result_record.h"
#include "tests/bench/samples.h"
#include "tests/bench/scenes.h"

namespace caustic::bench {
namespace {

// The ellipsoid bowl with another chord tolerance, cm.
service::PolylineSet bowl(double chord) {
  auto body = nlohmann::json::parse(service::find_example("ellipsoid-bowl")->body);
  body["tolerance"]["chord"] = chord;
  const service::ContourCall call = service::read_contour_call(body.dump());
  solver::ContourResult result = solver::trace_contours(call.system, call.request);
  return service::to_polylines(call, result);
}

void format(benchmark::State& state, const char* suffix, double chord) {
  const service::PolylineSet set = bowl(chord);
  const service::Format& format = *service::find_format(suffix);
  Samples samples;
  std::string file;
  for (auto _ : state) samples.time([&] { file = format.write(set); });
  samples.report_milliseconds(state);
  state.counters["vertices"] = static_cast<double>(set.vertices.size());
  state.counters["kB"] = 1e-3 * static_cast<double>(file.size());
}

constexpr double kCoarse = 0.02, kFine = 0.00045;
BENCHMARK_CAPTURE(format, vtp_1500, "vtp", kCoarse);
BENCHMARK_CAPTURE(format, vtp_10000, "vtp", kFine);
BENCHMARK_CAPTURE(format, svg_1500, "svg", kCoarse);
BENCHMARK_CAPTURE(format, svg_10000, "svg", kFine);
BENCHMARK_CAPTURE(format, csv_1500, "csv", kCoarse);
BENCHMARK_CAPTURE(format, csv_10000, "csv", kFine);

}  // namespace
}  // namespace caustic::bench
