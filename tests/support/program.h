// The real program as a child process.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace caustic::test {

struct ProgramResult {
  int exit_code;  ///< -1 if a signal ended it
  std::string out, err;
};

/// Runs the program to its end.
ProgramResult run_program(const std::vector<std::string>& arguments, const std::string& input = {});
/// All bytes of a file; none if it is not there.
std::string read_file(const std::filesystem::path& path);
/// Runs any command.
ProgramResult run_command(const std::vector<std::string>& command, const std::string& input = {});

/// `isocaustic serve` on a free loopback port, stopped by its process id.
class ServerProcess {
 public:
  explicit ServerProcess(const std::filesystem::path& data,
                         const std::vector<std::string>& more_arguments = {},
                         std::size_t file_size_limit = 0);
  ~ServerProcess();
  ServerProcess(const ServerProcess&) = delete;
  ServerProcess& operator=(const ServerProcess&) = delete;

  int port() const { return port_; }
  const std::string& first_line() const { return first_line_; }
  bool running() const;
  /// Sends the signal and waits. The exit code, or minus the signal that ended it.
  int stop(int signal);
  /// Largest resident set so far, KiB.
  long peak_memory() const;

 private:
  pid_t pid_ = -1;
  int port_ = 0;
  std::string first_line_;
};

}  // namespace caustic::test
