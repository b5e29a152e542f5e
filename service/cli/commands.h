// What each subcommand does, options already read. Each returns the program's exit code.
#pragma once

#include <string>
#include <vector>

#include "service/http/front.h"
#include "service/http/server.h"
#include "service/jobs/jobs.h"

namespace caustic::service {

struct ServeOptions {
  ServerOptions server;
  JobOptions jobs;
  FrontOptions front;
  std::string data;                      ///< folder of the results; empty: the user's cache folder
  std::uint64_t store_megabytes = 4096;  ///< that the results may take
  std::string token_file;                ///< whose first line clients must show; empty: none
  std::string log = "-";                 ///< "-" is stderr, "off" none, else a file
  int grace_ms = 5000;                   ///< for what runs when the service is told to stop
  bool open_to_all = false;              ///< a host other than loopback is meant
};
int serve(ServeOptions options);

struct TraceOptions {
  std::string request = "-";         ///< - is stdin
  std::string output = "-";          ///< - is stdout
  std::string format;                ///< empty: by the output's suffix, vtp for stdout
  std::vector<std::string> no_skip;  ///< stages to run although the scene does not need them
};
int trace(const TraceOptions& options);

/// Answer `POST /v1/irradiance` and `POST /v1/analysis` on stdout; - is stdin.
int irradiance(const std::string& request);
int analysis(const std::string& request);

/// Prints the request, or a list if there is no name.
int print_example(const std::string& name);

int check_health(const std::string& host, int port);

}  // namespace caustic::service
