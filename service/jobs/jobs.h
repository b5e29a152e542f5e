// All computations: queued, running, and those that ended not long ago.
#pragma once

#include <list>
#include <map>
#include <memory>

#include "service/jobs/job.h"
#include "service/jobs/job_files.h"
#include "service/jobs/workers.h"

namespace caustic::service {

struct JobOptions {
  int threads = 2;
  std::size_t most_waiting = 64;
};

class Jobs {
 public:
  /// `files` keeps what somebody may ask for later; without it nothing survives this object.
  explicit Jobs(const JobOptions& options, JobFiles* files = nullptr);
  ~Jobs();

  /// The job that is under way under this key, or a new one: works of one key must be
  /// interchangeable; an empty key is like no other. Throws ProblemError (503) if the queue is
  /// full.
  std::shared_ptr<Job> start(const std::string& key, JobWork work);
  /// Other work for the same threads. False if the queue is full.
  bool submit(std::function<void()> task) { return workers_.submit(std::move(task)); }

  /// From now on the job can be found by its id, and goes on if nobody waits. Throws ProblemError
  /// (507) if that cannot be written down; then it is as if it had not been asked.
  void keep(const std::shared_ptr<Job>& job);
  /// A job that was kept, here or by another server on the same folder.
  std::optional<JobReport> find(const std::string& id) const;
  /// `who` waits no longer (Job::wait). What nobody waits for is given up.
  void leave(const std::shared_ptr<Job>& job, const void* who);
  /// The report afterwards; nothing if there is no such job. Throws ProblemError (409) if it runs
  /// on another server.
  std::optional<JobReport> dismiss(const std::string& id);

  /// What waits ends now, what runs is told to; what is to come is refused.
  void interrupt();

  std::size_t waiting() const { return workers_.waiting(); }
  std::size_t running() const { return running_; }
  bool full() const { return workers_.full(); }

 private:
  void run(const std::shared_ptr<Job>& job);
  void ended(const JobReport& report);
  void give_up(const std::shared_ptr<Job>& job);
  std::shared_ptr<Job> kept_job(const std::string& id) const;

  JobFiles* files_;
  mutable std::mutex mutex_;
  bool stopping_ = false;
  std::map<std::string, std::shared_ptr<Job>> under_way_;  ///< by key, or by id if it has none
  std::map<std::string, std::shared_ptr<Job>> kept_;       ///< by id
  std::list<std::string> ended_;                           ///< ids of kept_, the oldest first
  std::atomic<std::size_t> running_ = 0;
  Workers workers_;  // last: its threads use all of the above
};

}  // namespace caustic::service
