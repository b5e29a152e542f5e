#include "service/jobs/job.h"

#include <algorithm>

namespace caustic::service {
namespace {

constexpr double kAlmost = 0.99;

JobOutcome outcome_of(const JobWork& work, JobControl& control) {
  try {
    return work(control);
  } catch (const ProblemError& error) {
    return error.problem();
  } catch (const std::exception& error) {
    return report_bug(error.what());
  } catch (...) {
    return report_bug("of no known type");
  }
}

Problem dismissed_problem() { return make_problem(503, "the computation was cancelled"); }
Problem interrupted_problem() { return make_problem(503, "interrupted: the service is stopping"); }

}  // namespace

void JobControl::expect(double seconds) {
  begin_ = std::chrono::steady_clock::now();
  seconds_ = seconds;
}

void JobControl::report(double share) {
  double before = reported_;
  while (share > before && !reported_.compare_exchange_weak(before, share)) {
  }
}

double JobControl::progress() const {
  const double seconds = seconds_;
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin_.load();
  const double of_time = seconds > 0.0 ? spent.count() / seconds : 0.0;
  return kAlmost * std::min(1.0, std::max(of_time, reported_.load()));
}

void JobControl::throw_if_cancelled() const {
  if (cancelled_) throw ProblemError(interrupted_problem());
}

double Job::age() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - created_).count();
}

JobReport Job::report_locked() const {
  JobReport out{id_, state_, progress(), {}, {}, waited_ ? *waited_ : age()};
  if (!outcome_) return out;
  if (const auto* result = std::get_if<JobResult>(&*outcome_)) {
    out.result_id = result->result_id;
    out.progress = 1.0;
  } else if (state_ == JobState::failed) {
    out.problem = std::get<Problem>(*outcome_);
  }
  return out;
}

JobReport Job::report() const {
  const std::lock_guard lock(mutex_);
  return report_locked();
}

bool Job::can_be_joined() const {
  const std::lock_guard lock(mutex_);
  return !outcome_ && !cancelled_;
}

void Job::wait(const void* who, Waiter waiter) {
  {
    const std::lock_guard lock(mutex_);
    if (!outcome_) return void(waiters_.emplace(who, std::move(waiter)));
  }
  waiter(*outcome_);  // once there it does not change
}

bool Job::leave(const void* who) {
  std::multimap<const void*, Waiter> gone;  // destroyed after the lock
  const std::lock_guard lock(mutex_);
  for (auto at = waiters_.find(who); at != waiters_.end() && at->first == who;)
    gone.insert(waiters_.extract(at++));
  if (gone.empty() || !waiters_.empty() || kept_ || outcome_) return false;
  return cancelled_ = true;
}

bool Job::keep() {
  const std::lock_guard lock(mutex_);
  if (outcome_ || cancelled_) return false;
  return kept_ = true;
}

bool Job::release() {
  const std::lock_guard lock(mutex_);
  kept_ = false;
  if (!waiters_.empty() || outcome_) return false;
  return cancelled_ = true;
}

void Job::run(const std::function<void(const JobReport&)>& ended) {
  JobWork work;
  {
    const std::lock_guard lock(mutex_);
    if (outcome_) return;
    state_ = JobState::running;
    waited_ = age();
    work.swap(work_);
  }
  JobOutcome outcome = cancelled_ ? JobOutcome(dismissed_problem()) : outcome_of(work, *this);
  work = {};
  bool dismissed;
  {
    const std::lock_guard lock(mutex_);
    dismissed = dismissed_ && !std::holds_alternative<JobResult>(outcome);
  }
  if (dismissed) return end(JobState::dismissed, dismissed_problem(), ended);
  const bool good = std::holds_alternative<JobResult>(outcome);
  end(good ? JobState::successful : JobState::failed, std::move(outcome), ended);
}

void Job::end(JobState state, JobOutcome outcome,
              const std::function<void(const JobReport&)>& ended) {
  std::multimap<const void*, Waiter> waiters;
  JobReport report;
  {
    const std::lock_guard lock(mutex_);
    if (outcome_) return;
    state_ = state;
    if (!waited_) waited_ = age();
    outcome_ = std::move(outcome);
    waiters.swap(waiters_);
    work_ = {};
    report = report_locked();
  }
  ended(report);
  for (const auto& [who, waiter] : waiters) waiter(*outcome_);
}

void Job::cancel(bool dismissed, const std::function<void(const JobReport&)>& ended) {
  bool waits = false;
  {
    const std::lock_guard lock(mutex_);
    if (outcome_) return;
    dismissed_ = dismissed;
    cancelled_ = true;
    waits = state_ == JobState::accepted;
  }
  if (!waits) return;
  if (dismissed)
    end(JobState::dismissed, dismissed_problem(), ended);
  else
    end(JobState::failed, interrupted_problem(), ended);
}

void Job::dismiss(const std::function<void(const JobReport&)>& ended) { cancel(true, ended); }
void Job::interrupt(const std::function<void(const JobReport&)>& ended) { cancel(false, ended); }

}  // namespace caustic::service
