// What each subcommand does, options already read. Each returns the program's exit code.
#pragma once

#include <string>

#include "service/http/server.h"

namespace caustic::service {

struct ServeOptions {
  ServerOptions server;
  std::string data;          ///< folder of the results; empty: the user's cache folder
  bool open_to_all = false;  ///< a host other than loopback is meant
};
int serve(const ServeOptions& options);

struct TraceOptions {
  std::string request = "-";  ///< - is stdin
  std::string output = "-";   ///< - is stdout
  std::string format;         ///< empty: by the output's suffix, vtp for stdout
};
int trace(const TraceOptions& options);

/// Answer `POST /v1/irradiance` and `POST /v1/analysis` on stdout; - is stdin.
int irradiance(const std::string& request);
int analysis(const std::string& request);

/// Prints the request, or a list if there is no name.
int print_example(const std::string& name);

int check_health(const std::string& host, int port);

}  // namespace caustic::service
