#include <fstream>
#include <functional>
#include <iostream>
#include <iterator>
#include <optional>

#include "service/api/answer_json.h"
#include "service/api/json_text.h"
#include "service/api/problem.h"
#include "service/cli/command_line.h"
#include "service/cli/commands.h"
#include "service/cli/progress_bar.h"
#include "service/contour_service.h"
#include "service/examples/examples.h"
#include "service/formats/format.h"
#include "service/point_service.h"

namespace caustic::service {
namespace {

std::optional<std::string> read_all(const std::string& path) {
  if (path == "-") return std::string(std::istreambuf_iterator<char>(std::cin), {});
  std::ifstream in(path, std::ios::binary);
  if (!in) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(in), {});
}

bool write_all(const std::string& path, const std::string& bytes) {
  if (path == "-")
    return static_cast<bool>(std::cout.write(bytes.data(), std::ssize(bytes)).flush());
  std::ofstream out(path, std::ios::binary);
  return static_cast<bool>(out.write(bytes.data(), std::ssize(bytes)).flush());
}

std::string format_name(const TraceOptions& options) {
  if (!options.format.empty()) return options.format;
  if (options.output == "-") return "vtp";
  const auto dot = options.output.rfind('.');
  return dot == std::string::npos ? "" : options.output.substr(dot + 1);
}

std::string output_bytes(const std::string& format, ContourCall& call,
                         solver::ContourResult& result) {
  const PolylineSet curves = to_polylines(call, result);
  for (const auto& [code, detail] : result.warnings)
    std::cerr << "warning: " << code << ": " << detail << std::endl;
  if (const Format* file = find_format(format)) return file->write(curves);
  return answer_json(call, result, result_id(call, result), false,
                     call.store ? std::string() : write_geojson(curves)) +
         "\n";
}

int report(const Problem& problem) {
  std::cerr << to_json(problem) << std::endl;
  return problem.status < 500 ? kBadInput : kFailed;
}

int trace_or_throw(const TraceOptions& options, const std::string& format) {
  const auto body = read_all(options.request);
  if (!body) return report(make_problem(400, "cannot read " + options.request));
  ContourCall call = read_contour_call(*body);
  call.request.no_skip = {options.no_skip.begin(), options.no_skip.end()};
  solver::ContourResult result;
  {
    ProgressBar bar;
    call.request.progress = bar.callback();
    result = solver::trace_contours(call.system, call.request);
  }
  throw_if_unsupported(result);
  if (write_all(options.output, output_bytes(format, call, result))) return kDone;
  return report(make_problem(507, "cannot write " + options.output));
}

using Answer = std::string (*)(std::string_view body, const std::atomic<bool>* stopping);

int print_or_throw(const std::string& request, Answer answer) {
  const auto body = read_all(request);
  if (!body) return report(make_problem(400, "cannot read " + request));
  if (write_all("-", answer(*body, nullptr) + "\n")) return kDone;
  return report(make_problem(507, "cannot write -"));
}

/// The one boundary of what goes wrong on the command line.
int guarded(const std::function<int()>& command) {
  try {
    return command();
  } catch (const ProblemError& error) {
    return report(error.problem());
  } catch (const std::exception& error) {
    std::cerr << "internal error: " << error.what() << std::endl;
    return kFailed;
  }
}

}  // namespace

int trace(const TraceOptions& options) {
  const std::string format = format_name(options);
  if (format != "json" && !find_format(format))
    return report(
        make_problem(400, "unknown format '" + format + "': vtp, vtk, svg, geojson, csv or json"));
  return guarded([&] { return trace_or_throw(options, format); });
}

int irradiance(const std::string& request) {
  return guarded([&] { return print_or_throw(request, answer_irradiance); });
}

int analysis(const std::string& request) {
  return guarded([&] { return print_or_throw(request, answer_analysis); });
}

int print_example(const std::string& name) {
  if (name.empty()) {
    for (const Example& example : examples())
      std::cout << example.name
                << std::string(20 - std::min<std::size_t>(19, example.name.size()), ' ')
                << example.title << '\n';
    return kDone;
  }
  const Example* example = find_example(name);
  if (!example) return report(make_problem(404, "no example is called '" + name + "'"));
  std::cout << example->body;
  return kDone;
}

}  // namespace caustic::service
