#include "service/jobs/job_files.h"

#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>
#include <chrono>
#include <system_error>

#include "service/api/identity.h"
#include "service/results/atomic_file.h"

namespace caustic::service {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kJobSuffix = ".job", kServerSuffix = ".server";
constexpr auto kJobMemory = std::chrono::hours(24 * 7);  // of what has ended, or failed

/// True if nobody holds the lock, or there is none.
bool is_free(const fs::path& path) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  return !file || ::flock(file.get(), LOCK_SH | LOCK_NB) == 0;
}

}  // namespace

JobFiles::JobFiles(fs::path folder) : folder_(std::move(folder)) {
  if (fs::is_directory(folder_)) sweep();
}

void JobFiles::open_folder() {
  const std::lock_guard lock(mutex_);
  if (lock_) return;
  fs::create_directories(folder_);
  owner_ = random_id();
  const fs::path path = folder_ / (owner_ + std::string(kServerSuffix));
  lock_ = Descriptor(::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (!lock_ || ::flock(lock_.get(), LOCK_EX | LOCK_NB) != 0)
    throw std::system_error(errno, std::generic_category(), "lock");
}

JobFiles::~JobFiles() {
  std::error_code ignored;
  if (lock_) fs::remove(folder_ / (owner_ + std::string(kServerSuffix)), ignored);
}

void JobFiles::sweep() const {
  std::error_code ignored;  // another server may sweep the same folder
  const auto now = fs::file_time_type::clock::now();
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    const std::string suffix = entry.path().extension().string();
    const bool old = now - entry.last_write_time(ignored) > kJobMemory;
    if ((suffix == kJobSuffix && old) || (suffix == kServerSuffix && is_free(entry.path())))
      fs::remove(entry.path(), ignored);
  }
  sweep_temporaries(folder_);
}

/// A job's file: the server's name, a line feed, the report.
bool JobFiles::save(const JobReport& report) {
  try {
    open_folder();
    replace_file(folder_ / (report.id + std::string(kJobSuffix)), owner_ + "\n" + to_json(report));
    return true;
  } catch (const std::system_error&) {
    return false;
  }
}

std::optional<JobReport> JobFiles::load(const std::string& id) const {
  if (!is_id(id)) return std::nullopt;
  const auto text = read_file(folder_ / (id + std::string(kJobSuffix)));
  if (!text) return std::nullopt;
  const auto line = text->find('\n');
  auto report = read_job_report(std::string_view(*text).substr(std::min(line, text->size())));
  const std::string owner = text->substr(0, line);
  if (!report || report->ended() || !is_id(owner)) return report;
  if (is_free(folder_ / (owner + std::string(kServerSuffix)))) {
    report->state = JobState::failed;
    report->problem = make_problem(503, "interrupted: the service was stopped; post it again");
  }
  return report;
}

}  // namespace caustic::service
