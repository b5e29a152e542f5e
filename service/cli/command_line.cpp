#include "service/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <thread>

#include "service/api/identity.h"
#include "service/cli/commands.h"
#include "solver/plan.h"

namespace caustic::service {
namespace {

/// An option that the environment sets too: --max-body is ISOCAUSTIC_MAX_BODY.
template <typename Value>
CLI::Option* add_setting(CLI::App& command, std::string name, Value& value, const char* help) {
  CLI::Option* option = command.add_option("--" + name, value, help);
  for (char& c : name) c = c == '-' ? '_' : static_cast<char>(std::toupper(c));
  return option->envname("ISOCAUSTIC_" + name);
}

void add_limits(CLI::App& command, ServeOptions& options) {
  ReactorOptions& reactor = options.server.reactor;
  add_setting(command, "max-body", reactor.max_body, "largest request body, bytes")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 30))
      ->capture_default_str();
  add_setting(command, "max-connections", reactor.max_connections,
              "connections at a time; then idle ones are closed")
      ->check(CLI::Range(std::size_t{1}, std::size_t{100'000}))
      ->capture_default_str();
  add_setting(command, "threads", reactor.threads, "threads that talk to clients")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  add_setting(command, "workers", options.jobs.threads, "threads that compute")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  add_setting(command, "queue", options.jobs.most_waiting,
              "computations that may wait; then 503 is answered")
      ->check(CLI::Range(std::size_t{1}, std::size_t{100'000}))
      ->capture_default_str();
  add_setting(command, "store-size", options.store_megabytes,
              "MiB that results may take; then the least asked for go")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{1} << 30))
      ->capture_default_str();
}

void add_serve(CLI::App& app, ServeOptions& options) {
  auto& command = *app.add_subcommand("serve", "start the HTTP service");
  options.jobs.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  add_setting(command, "host", options.server.host, "address to listen on")->capture_default_str();
  add_setting(command, "port", options.server.port, "0 picks a free one")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  command.add_flag("--public", options.open_to_all, "allow a host other than loopback")
      ->envname("ISOCAUSTIC_PUBLIC");
  add_setting(command, "data", options.data,
              "folder of the results (default ${XDG_CACHE_HOME:-~/.cache}/isocaustic)");
  add_limits(command, options);
  add_setting(command, "token-file", options.token_file,
              "file with a token that clients must send (Authorization: Bearer ...)");
  add_setting(command, "cors-origin", options.front.origins,
              "origin of a page elsewhere that may ask, as https://example.org; may be repeated")
      ->delimiter(',');
  add_setting(command, "log", options.log, "a line of JSON a request: - is stderr, off is none")
      ->capture_default_str();
  add_setting(command, "grace", options.grace_ms,
              "ms that computations may still take when told to stop")
      ->check(CLI::Range(0, 3'600'000))
      ->capture_default_str();
}

void add_trace(CLI::App& app, TraceOptions& options) {
  auto* command = app.add_subcommand("trace", "trace one request into a file");
  command->add_option("request", options.request, "request file, - is stdin")->required();
  command->add_option("-o,--output", options.output, "output file, - is stdout")
      ->capture_default_str();
  command->add_option("--format", options.format,
                      "vtp, vtk, svg, geojson, csv or json (default: the output's suffix)");
  const auto stages = solver::skippable_stages();
  command
      ->add_option("--no-skip", options.no_skip,
                   "a stage to run although the scene does not need it, to see what it would take; "
                   "may be repeated")
      ->check(CLI::IsMember(std::vector<std::string>(stages.begin(), stages.end())));
}

}  // namespace

int run_command_line(int argc, char** argv) {
  CLI::App app("Isocaustic: isolux curves and caustics cast by mirrors", "isocaustic");
  app.set_version_flag("--version", std::string("isocaustic ") + kEngineVersion);
  app.require_subcommand(1);
  ServeOptions serve_options;
  add_serve(app, serve_options);
  TraceOptions trace_options;
  add_trace(app, trace_options);
  std::string irradiance_request;
  app.add_subcommand("irradiance", "read the light at points of the receiver")
      ->add_option("request", irradiance_request, "request file, - is stdin")
      ->required();
  std::string analysis_request;
  app.add_subcommand("analysis", "flux, extremes and uniformity of the light on the receiver")
      ->add_option("request", analysis_request, "request file, - is stdin")
      ->required();
  std::string example;
  app.add_subcommand("example", "print a ready request")
      ->add_option("name", example, "without it: list them all");
  ServerOptions health;
  auto* health_command = app.add_subcommand("health", "ask a running service whether it is well");
  health_command->add_option("--host", health.host)->capture_default_str();
  health_command->add_option("--port", health.port)
      ->check(CLI::Range(1, 65535))
      ->capture_default_str();

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kBadInput;
  }
  if (app.got_subcommand("serve")) return serve(serve_options);
  if (app.got_subcommand("trace")) return trace(trace_options);
  if (app.got_subcommand("irradiance")) return irradiance(irradiance_request);
  if (app.got_subcommand("analysis")) return analysis(analysis_request);
  if (app.got_subcommand("example")) return print_example(example);
  return check_health(health.host, health.port);
}

}  // namespace caustic::service
