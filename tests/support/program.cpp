#include "tests/support/program.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iterator>

#include "tests/support/temporary_folder.h"

namespace caustic::test {
namespace {

std::vector<char*> pointers(std::vector<std::string>& strings) {
  std::vector<char*> out;
  for (std::string& s : strings) out.push_back(s.data());
  out.push_back(nullptr);
  return out;
}

/// In the child: standard streams from and to files.
void redirect(int stream, const std::filesystem::path& path, int flags) {
  const int file = open(path.c_str(), flags, 0600);
  dup2(file, stream);
  close(file);
}

}  // namespace

std::string read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(in), {});
}

ProgramResult run_command(const std::vector<std::string>& command, const std::string& input) {
  const TemporaryFolder folder;
  const auto in = folder.path() / "in", out = folder.path() / "out", err = folder.path() / "err";
  std::ofstream(in, std::ios::binary) << input;
  std::vector<std::string> copy = command;
  const std::vector<char*> argv = pointers(copy);
  const pid_t pid = fork();
  if (pid == 0) {
    redirect(0, in, O_RDONLY);
    redirect(1, out, O_WRONLY | O_CREAT);
    redirect(2, err, O_WRONLY | O_CREAT);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  int status = 0;
  waitpid(pid, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(out), read_file(err)};
}

ProgramResult run_program(const std::vector<std::string>& arguments, const std::string& input) {
  std::vector<std::string> command{ISOCAUSTIC_PROGRAM};
  command.insert(command.end(), arguments.begin(), arguments.end());
  return run_command(command, input);
}

ServerProcess::ServerProcess(const std::filesystem::path& data,
                             const std::vector<std::string>& more_arguments,
                             std::size_t file_size_limit) {
  std::vector<std::string> command{ISOCAUSTIC_PROGRAM, "serve",      "--port", "0",
                                   "--data",           data.string()};
  command.insert(command.end(), more_arguments.begin(), more_arguments.end());
  const std::vector<char*> argv = pointers(command);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return;
  pid_ = fork();
  if (pid_ == 0) {
    dup2(ends[1], 1);
    const rlimit limit{file_size_limit, file_size_limit};
    if (file_size_limit) setrlimit(RLIMIT_FSIZE, &limit);
    setenv("ISOCAUSTIC_LOG", "off", 0);  // options come before the environment
    execv(argv[0], argv.data());
    _exit(127);
  }
  close(ends[1]);
  for (char c; ::read(ends[0], &c, 1) == 1 && c != '\n';) first_line_ += c;
  close(ends[0]);
  const auto colon = first_line_.rfind(':');
  if (colon != std::string::npos) port_ = std::atoi(first_line_.c_str() + colon + 1);
}

ServerProcess::~ServerProcess() { stop(SIGKILL); }

bool ServerProcess::running() const { return pid_ > 0 && waitpid(pid_, nullptr, WNOHANG) == 0; }

int ServerProcess::stop(int signal) {
  if (pid_ <= 0) return 0;
  kill(pid_, signal);
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

long ServerProcess::peak_memory() const {
  std::ifstream status("/proc/" + std::to_string(pid_) + "/status");
  for (std::string word; status >> word;) {
    if (word != "VmHWM:") continue;
    long kib = 0;
    status >> kib;
    return kib;
  }
  return -1;
}

}  // namespace caustic::test
