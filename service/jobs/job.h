// One computation: who waits for it, how far it is, how it ended.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <variant>

#include "service/jobs/job_report.h"

namespace caustic::service {

struct JobResult {
  std::string answer;
  std::string result_id = {};  ///< under which it is stored, if it is
};
/// A problem is passed on as a value: who waits in several threads shares no exception.
using JobOutcome = std::variant<JobResult, Problem>;

/// What a computation sees of its job.
class JobControl {
 public:
  /// True once nobody wants the result any more, or the service stops.
  const std::atomic<bool>* cancelled() const { return &cancelled_; }
  /// The computation begins now and takes at most so many seconds.
  void expect(double seconds);
  /// The share that is done. Never goes back.
  void report(double share);
  /// What is done for sure is seldom known; that it ends when its time is up is. The larger share
  /// counts, and all is said to be done only when it is.
  double progress() const;
  /// Throws ProblemError (503) if it is cancelled.
  void throw_if_cancelled() const;

 protected:
  std::atomic<bool> cancelled_ = false;
  std::atomic<double> reported_ = 0.0;
  std::atomic<double> seconds_ = 0.0;
  std::atomic<std::chrono::steady_clock::time_point> begin_{};
};

/// Throws ProblemError for what is wrong with the request.
using JobWork = std::function<JobResult(JobControl&)>;

class Job : public JobControl {
 public:
  using Waiter = std::function<void(const JobOutcome&)>;

  Job(std::string id, JobWork work)
      : id_(std::move(id)), created_(std::chrono::steady_clock::now()), work_(std::move(work)) {}

  const std::string& id() const { return id_; }
  JobReport report() const;
  using JobControl::report;
  /// False once it was given up, for then it gives no answer, or has ended: who has heard how, and
  /// asks again, wants another one.
  bool can_be_joined() const;

  /// Calls `waiter` with the outcome: now if it is there, else from the thread that finds it.
  /// `who` is whatever leave() will be called with.
  void wait(const void* who, Waiter waiter);
  /// This one waits no longer. True if it was the last one and the job is not kept: then it is
  /// cancelled.
  bool leave(const void* who);
  /// It goes on even if nobody waits: somebody may ask for it later. False if it has ended.
  bool keep();
  /// Takes keep() back. True if nobody waits for it: then it is cancelled.
  bool release();

  /// Does the work, or nothing if it was cancelled before. `ended` is called before any waiter.
  void run(const std::function<void(const JobReport&)>& ended);
  /// Ends it as soon as the computation looks up; at once if that has not begun.
  void dismiss(const std::function<void(const JobReport&)>& ended);
  /// The same, because the service stops: it failed, and was interrupted.
  void interrupt(const std::function<void(const JobReport&)>& ended);

 private:
  void end(JobState state, JobOutcome outcome, const std::function<void(const JobReport&)>& ended);
  void cancel(bool dismissed, const std::function<void(const JobReport&)>& ended);
  JobReport report_locked() const;
  double age() const;

  const std::string id_;
  const std::chrono::steady_clock::time_point created_;
  mutable std::mutex mutex_;
  std::optional<double> waited_;  ///< once it waits no longer, s
  JobWork work_;
  JobState state_ = JobState::accepted;
  bool kept_ = false, dismissed_ = false;
  std::multimap<const void*, Waiter> waiters_;
  std::optional<JobOutcome> outcome_;
};

}  // namespace caustic::service
