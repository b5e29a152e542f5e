// Jobs that somebody may ask for later, one small file each, so that any server on the same folder
// can tell of them, also after the one that ran them is gone. Each server holds a lock for as long
// as it lives; a job that has not ended and whose server's lock is free was interrupted.
#pragma once

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>

#include "service/descriptor.h"
#include "service/jobs/job_report.h"

namespace caustic::service {

class JobFiles {
 public:
  /// The folder is made when the first job is written. What killed servers left in it is swept now.
  explicit JobFiles(std::filesystem::path folder);
  ~JobFiles();
  JobFiles(const JobFiles&) = delete;
  JobFiles& operator=(const JobFiles&) = delete;

  /// Returns once it is on disk; false if it could not be written.
  bool save(const JobReport& report);
  /// As its server last wrote it, or failed if that is gone.
  std::optional<JobReport> load(const std::string& id) const;

 private:
  void open_folder();
  void sweep() const;

  const std::filesystem::path folder_;
  std::mutex mutex_;  // of the opening
  std::string owner_;
  Descriptor lock_;
};

}  // namespace caustic::service
