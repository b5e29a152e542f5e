#include "service/jobs/jobs.h"

#include <gtest/gtest.h>

#include <fstream>
#include <future>
#include <nlohmann/json.hpp>

#include "service/http/job_events.h"
#include "tests/support/temporary_folder.h"

namespace caustic::service {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

/// Work that runs until it is told to go on, or is cancelled.
class Gate {
 public:
  JobWork work(const std::string& answer = "done") {
    return [this, answer](JobControl& control) {
      ++entered;
      while (!open && !*control.cancelled()) std::this_thread::sleep_for(milliseconds(1));
      control.throw_if_cancelled();
      return JobResult{answer, std::string(64, 'a')};
    };
  }
  void wait_for(int count) const {
    for (int i = 0; i < 10'000 && entered < count; ++i)
      std::this_thread::sleep_for(milliseconds(1));
    ASSERT_EQ(entered, count);
  }
  std::atomic<int> entered = 0;
  std::atomic<bool> open = false;
};

/// What the job ended with, as soon as it has.
std::future<JobOutcome> outcome_of(const std::shared_ptr<Job>& job, const void* who = nullptr) {
  const auto promise = std::make_shared<std::promise<JobOutcome>>();
  job->wait(who, [promise](const JobOutcome& outcome) { promise->set_value(outcome); });
  return promise->get_future();
}

TEST(Jobs, equal_ones_are_done_once) {
  Gate gate;
  Jobs jobs({2, 8});
  const auto first = jobs.start("key", gate.work()), second = jobs.start("key", gate.work());
  const auto other = jobs.start("", gate.work()), another = jobs.start("", gate.work());
  EXPECT_EQ(first, second);
  EXPECT_NE(other, another);
  auto outcome = outcome_of(first), same = outcome_of(second);
  gate.open = true;
  EXPECT_EQ(std::get<JobResult>(outcome.get()).answer, "done");
  EXPECT_EQ(std::get<JobResult>(same.get()).answer, "done");
  outcome_of(other).wait();
  outcome_of(another).wait();
  EXPECT_EQ(gate.entered, 3);
  EXPECT_NE(jobs.start("key", gate.work()), first);  // what has ended is not joined
}

/// Who has heard that one failed, and asks again, is not told the same of the same one.
TEST(Jobs, what_has_ended_is_not_joined_from_the_first_moment_on) {
  Jobs jobs({1, 8});
  const JobWork fails = [](JobControl&) -> JobResult {
    throw ProblemError(make_problem(503, "not now"));
  };
  for (int i = 0; i < 2000; ++i) {
    const auto first = jobs.start("key", fails);
    while (!first->report().ended()) {
    }
    ASSERT_NE(jobs.start("key", fails), first) << i;
  }
}

TEST(Jobs, a_full_queue_takes_no_more) {
  Gate gate;
  Jobs jobs({1, 2});
  std::vector<std::shared_ptr<Job>> taken{jobs.start("", gate.work())};
  gate.wait_for(1);
  taken.push_back(jobs.start("", gate.work()));
  EXPECT_FALSE(jobs.full());
  taken.push_back(jobs.start("", gate.work()));
  EXPECT_TRUE(jobs.full());
  EXPECT_THROW(jobs.start("", gate.work()), ProblemError);
  gate.open = true;
  for (const auto& job : taken)
    EXPECT_TRUE(std::holds_alternative<JobResult>(outcome_of(job).get()));
  outcome_of(jobs.start("", gate.work())).wait();
}

TEST(Jobs, go_on_as_long_as_somebody_waits) {
  Gate gate;
  Jobs jobs({1, 8});
  const auto job = jobs.start("key", gate.work());
  gate.wait_for(1);
  int one, two;
  auto first = outcome_of(job, &one), second = outcome_of(job, &two);
  jobs.leave(job, &one);
  jobs.leave(job, &one);
  EXPECT_FALSE(*job->cancelled());
  jobs.leave(job, &two);
  EXPECT_TRUE(*job->cancelled());
  const auto next = jobs.start("key", gate.work());  // the cancelled one is not joined
  EXPECT_NE(next, job);
  gate.open = true;
  EXPECT_TRUE(std::holds_alternative<JobResult>(outcome_of(next).get()));
  EXPECT_EQ(std::get<Problem>(outcome_of(job).get()).status, 503);
}

TEST(Jobs, are_found_once_kept_and_outlive_who_waits) {
  Gate gate;
  Jobs jobs({1, 8});
  const auto job = jobs.start("key", gate.work());
  EXPECT_FALSE(jobs.find(job->id()));
  jobs.keep(job);
  gate.wait_for(1);
  auto outcome = outcome_of(job, &gate);
  jobs.leave(job, &gate);
  EXPECT_FALSE(*job->cancelled());
  EXPECT_EQ(jobs.find(job->id())->state, JobState::running);
  job->JobControl::report(0.5);
  job->JobControl::report(0.25);
  EXPECT_EQ(jobs.find(job->id())->progress, 0.99 * 0.5);
  gate.open = true;
  outcome_of(job).wait();
  const JobReport report = *jobs.find(job->id());
  EXPECT_EQ(report.state, JobState::successful);
  EXPECT_EQ(json::parse(to_json(report)), json({{"id", job->id()},
                                                {"status", "successful"},
                                                {"progress", 1.0},
                                                {"result", "/v1/results/" + std::string(64, 'a')},
                                                {"problem", nullptr}}));
  EXPECT_FALSE(jobs.find(std::string(64, '0')));
  EXPECT_FALSE(jobs.dismiss(std::string(64, '0')));
}

TEST(Jobs, are_dismissed_while_they_wait_and_while_they_run) {
  Gate gate;
  Jobs jobs({1, 8});
  const auto runs = jobs.start("", gate.work()), waits = jobs.start("", gate.work());
  jobs.keep(runs);
  jobs.keep(waits);
  gate.wait_for(1);
  EXPECT_EQ(jobs.waiting(), 1u);
  EXPECT_EQ(jobs.dismiss(waits->id())->state, JobState::dismissed);
  EXPECT_EQ(jobs.waiting(), 0u);  // it made room at once
  jobs.dismiss(runs->id());
  EXPECT_EQ(std::get<Problem>(outcome_of(runs).get()).status, 503);
  EXPECT_EQ(jobs.find(runs->id())->state, JobState::dismissed);
  EXPECT_EQ(jobs.dismiss(runs->id())->state, JobState::dismissed);
  outcome_of(jobs.start("", [](JobControl&) { return JobResult{}; })).wait();
  EXPECT_EQ(gate.entered, 1);  // what was dismissed before it began never did
}

TEST(Jobs, fail_with_the_problem) {
  Jobs jobs({1, 8});
  const auto job = jobs.start("", [](JobControl&) -> JobResult {
    throw ProblemError(make_problem(422, "no", {{"/a", "b"}}));
  });
  jobs.keep(job);
  EXPECT_EQ(std::get<Problem>(outcome_of(job).get()).status, 422);
  const JobReport report = *jobs.find(job->id());
  EXPECT_EQ(report.state, JobState::failed);
  EXPECT_EQ(json::parse(to_json(report))["problem"]["errors"][0]["pointer"], "/a");
  EXPECT_EQ(to_json(*read_job_report(to_json(report))), to_json(report));
  EXPECT_FALSE(read_job_report("{}"));
  EXPECT_FALSE(read_job_report(R"({"id":"x","status":"asleep","progress":0})"));
}

TEST(Jobs, are_known_to_every_server_on_the_folder_and_to_those_that_come) {
  const test::TemporaryFolder folder;
  const auto place = folder.path() / "jobs";
  std::string ended, interrupted;
  JobFiles own_files(place);
  Gate gate;
  {
    JobFiles files(place);
    Jobs jobs({1, 8}, &files);
    EXPECT_FALSE(std::filesystem::exists(place));  // nothing was kept
    const auto first = jobs.start("", [](JobControl&) {
      return JobResult{"{}", std::string(64, 'b')};
    });
    jobs.keep(first);
    outcome_of(first).wait();
    const auto second = jobs.start("", gate.work());
    jobs.keep(second);
    ended = first->id();
    interrupted = second->id();
    Jobs other({1, 8}, &own_files);
    EXPECT_EQ(other.find(ended)->result_id, std::string(64, 'b'));
    EXPECT_FALSE(other.find(interrupted)->ended());
    try {
      other.dismiss(interrupted);
      FAIL();
    } catch (const ProblemError& error) {
      EXPECT_EQ(error.problem().status, 409);
    }
  }
  Jobs later({1, 8}, &own_files);
  EXPECT_EQ(later.find(ended)->state, JobState::successful);
  EXPECT_EQ(later.find(interrupted)->state, JobState::failed);
  EXPECT_NE(later.find(interrupted)->problem->detail.find("interrupted"), std::string::npos);
}

TEST(Jobs, that_cannot_be_written_down_are_not_kept_and_not_worked_at) {
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "jobs") << "a file where the folder should be";
  JobFiles files(folder.path() / "jobs");
  Gate gate;
  Jobs jobs({1, 8}, &files);
  const auto kept = [&](const std::shared_ptr<Job>& job) {
    try {
      jobs.keep(job);
    } catch (const ProblemError& error) {
      EXPECT_EQ(error.problem().status, 507);
      return false;
    }
    return true;
  };
  const auto alone = jobs.start("", gate.work());
  gate.wait_for(1);
  EXPECT_FALSE(kept(alone));
  EXPECT_TRUE(*alone->cancelled());
  const auto waited_for = jobs.start("", gate.work());
  auto outcome = outcome_of(waited_for);
  EXPECT_FALSE(kept(waited_for));
  EXPECT_FALSE(*waited_for->cancelled());
  gate.open = true;
  EXPECT_TRUE(std::holds_alternative<JobResult>(outcome.get()));
  std::filesystem::remove(folder.path() / "jobs");
  for (const auto& job : {alone, waited_for}) EXPECT_FALSE(jobs.find(job->id()));
}

TEST(Jobs, more_than_are_remembered_are_read_from_their_files) {
  const test::TemporaryFolder folder;
  JobFiles files(folder.path());
  Jobs jobs({1, 8}, &files);
  std::vector<std::string> ids;
  for (int i = 0; i < 70; ++i) {
    const auto job = jobs.start("", [](JobControl&) { return JobResult{}; });
    jobs.keep(job);
    outcome_of(job).wait();
    ids.push_back(job->id());
  }
  for (const std::string& id : ids) EXPECT_EQ(jobs.find(id)->state, JobState::successful);
  EXPECT_FALSE(files.load("../jobs"));
}

TEST(JobEvents, tell_each_change_once_and_the_end) {
  JobReport report;
  report.id = "x";
  JobEvents events([&] { return std::optional(report); });
  std::string out;
  EXPECT_TRUE(events.next(out));
  EXPECT_TRUE(out.starts_with("id: 1\nevent: job\ndata: {\"id\":\"x\",\"status\":\"accepted\""));
  EXPECT_TRUE(out.ends_with("}\n\n"));
  const std::string before = out;
  EXPECT_TRUE(events.next(out));
  EXPECT_EQ(out, before);
  report.progress = 0.5;
  EXPECT_TRUE(events.next(out));
  EXPECT_NE(out.find("id: 2\n"), out.npos);
  report.state = JobState::dismissed;
  EXPECT_FALSE(events.next(out));
  EXPECT_NE(out.find("id: end\nevent: end\ndata: "), out.npos);
}

}  // namespace
}  // namespace caustic::service
