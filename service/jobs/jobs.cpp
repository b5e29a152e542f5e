#include "service/jobs/jobs.h"

#include "service/api/identity.h"

namespace caustic::service {
namespace {

/// So many jobs that have ended are remembered with their answers; the files remember longer.
constexpr std::size_t kRemembered = 64;

}  // namespace

Jobs::Jobs(const JobOptions& options, JobFiles* files)
    : files_(files), workers_(options.threads, options.most_waiting) {}

Jobs::~Jobs() { interrupt(); }

std::shared_ptr<Job> Jobs::start(const std::string& key, JobWork work) {
  const std::lock_guard lock(mutex_);
  if (stopping_) throw ProblemError(make_problem(503, "the service is stopping"));
  if (const auto found = under_way_.find(key);
      found != under_way_.end() && found->second->can_be_joined())
    return found->second;
  auto job = std::make_shared<Job>(random_id(), std::move(work));
  const std::string name = key.empty() ? job->id() : key;
  if (!workers_.submit([this, job] { run(job); }, job.get()))
    throw ProblemError(make_problem(503, "too many computations are waiting"));
  under_way_[name] = job;
  return job;
}

void Jobs::run(const std::shared_ptr<Job>& job) {
  ++running_;
  if (files_ && kept_job(job->id())) {
    JobReport report = job->report();
    if (report.state == JobState::accepted) {
      report.state = JobState::running;
      files_->save(report);
    }
  }
  job->run([&](const JobReport& report) { ended(report); });
  --running_;
}

void Jobs::ended(const JobReport& report) {
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(under_way_, [&](const auto& entry) { return entry.second->id() == report.id; });
    if (!kept_.contains(report.id)) return;
    ended_.push_back(report.id);
    for (; ended_.size() > kRemembered; ended_.pop_front()) kept_.erase(ended_.front());
  }
  if (files_) files_->save(report);
}

void Jobs::keep(const std::shared_ptr<Job>& job) {
  {
    const std::lock_guard lock(mutex_);
    if (!kept_.emplace(job->id(), job).second) return;
  }
  const bool runs = job->keep();
  // The file must say how it ended, whichever of the two comes first.
  if (files_ && !files_->save(job->report())) {
    {
      const std::lock_guard lock(mutex_);
      kept_.erase(job->id());
    }
    if (job->release()) give_up(job);
    throw ProblemError(make_problem(507, "the job cannot be written down"));
  }
  if (!runs || job->report().ended()) ended(job->report());
}

std::shared_ptr<Job> Jobs::kept_job(const std::string& id) const {
  const std::lock_guard lock(mutex_);
  const auto found = kept_.find(id);
  return found == kept_.end() ? nullptr : found->second;
}

std::optional<JobReport> Jobs::find(const std::string& id) const {
  if (const auto job = kept_job(id)) return job->report();
  return files_ ? files_->load(id) : std::nullopt;
}

std::optional<JobReport> Jobs::dismiss(const std::string& id) {
  if (const auto job = kept_job(id)) {
    job->dismiss([&](const JobReport& report) { ended(report); });
    workers_.withdraw(job.get());
    return job->report();
  }
  auto report = find(id);
  if (report && !report->ended())
    throw ProblemError(make_problem(409, "the job runs on another server"));
  return report;
}

void Jobs::leave(const std::shared_ptr<Job>& job, const void* who) {
  if (job->leave(who)) give_up(job);
}

void Jobs::give_up(const std::shared_ptr<Job>& job) {
  job->interrupt([&](const JobReport& report) { ended(report); });
  workers_.withdraw(job.get());
}

void Jobs::interrupt() {
  std::map<std::string, std::shared_ptr<Job>> jobs;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    jobs = under_way_;
  }
  for (const auto& [key, job] : jobs)
    job->interrupt([&](const JobReport& report) { ended(report); });
}

}  // namespace caustic::service
