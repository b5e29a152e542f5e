#include "service/cli/command_line.h"

#include <CLI/CLI.hpp>

#include "service/api/identity.h"
#include "service/cli/commands.h"

namespace caustic::service {
namespace {

void add_serve(CLI::App& app, ServeOptions& options) {
  auto* command = app.add_subcommand("serve", "start the HTTP service");
  command->add_option("--host", options.server.host, "address to listen on")->capture_default_str();
  command->add_option("--port", options.server.port, "0 picks a free one")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  command->add_option("--data", options.data,
                      "folder of the results (default ${XDG_CACHE_HOME:-~/.cache}/isocaustic)");
  command->add_option("--max-body", options.server.max_body, "largest request body, bytes")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 30))
      ->capture_default_str();
  command->add_option("--threads", options.server.threads, "connections served at a time")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  command->add_flag("--public", options.open_to_all, "allow a host other than loopback");
}

void add_trace(CLI::App& app, TraceOptions& options) {
  auto* command = app.add_subcommand("trace", "trace one request into a file");
  command->add_option("request", options.request, "request file, - is stdin")->required();
  command->add_option("-o,--output", options.output, "output file, - is stdout")
      ->capture_default_str();
  command->add_option("--format", options.format,
                      "vtp, vtk, svg, geojson, csv or json (default: the output's suffix)");
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
