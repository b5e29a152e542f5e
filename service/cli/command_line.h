// The program's subcommands.
#pragma once

namespace caustic::service {

/// Exit codes of the program.
enum ExitCode { kDone = 0, kFailed = 1, kBadInput = 2 };

int run_command_line(int argc, char** argv);

}  // namespace caustic::service
