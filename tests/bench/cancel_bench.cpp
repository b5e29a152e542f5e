// How long a job takes to end once it is dismissed, beside another that keeps the other worker
// busy: the longest of several moments, by the clock and by the worker's own time, which other
// programs on the machine do not lengthen.
#include <benchmark/benchmark.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>

#include "service/contour_service.h"
#include "service/examples/examples.h"
#include "service/jobs/jobs.h"
#include "tests/support/temporary_folder.h"

namespace caustic::bench {
namespace {

using nlohmann::json;
using service::JobControl;
using service::JobResult;

constexpr std::array kMoments{0.03, 0.1, 0.3, 1.0, 3.0};  // s after the beginning

/// The thread that computes, once it does.
struct Worker {
  std::promise<clockid_t> began;
  double ended = 0.0;
};

double seconds_of(clockid_t clock) {
  timespec time;
  clock_gettime(clock, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

std::shared_ptr<service::Job> start(service::Jobs& jobs, const service::ContourService& contours,
                                    const std::string& body, Worker* worker = nullptr) {
  const auto call = std::make_shared<service::ContourCall>(service::read_contour_call(body));
  return jobs.start("", [&contours, call, worker](JobControl& control) {
    clockid_t clock = CLOCK_THREAD_CPUTIME_ID;
    if (worker) {
      pthread_getcpuclockid(pthread_self(), &clock);
      worker->began.set_value(clock);
    }
    struct Note {
      Worker* worker;
      ~Note() {
        if (worker) worker->ended = seconds_of(CLOCK_THREAD_CPUTIME_ID);
      }
    } note{worker};
    return contours.compute(*call, control);
  });
}

/// Much to do: all of it at its finest.
std::string finest_request(const char* example, bool certify) {
  json body = json::parse(service::find_example(example)->body);
  body["certify"] = certify;
  body["tolerance"]["chord"] = 1e-6 * body["scene"]["receiver"]["size"][0].get<double>();
  body["limits"] = {{"time_ms", 60000}, {"vertices", 2000000}};
  return body.dump();
}

void cancel(benchmark::State& state, const char* example, bool certify) {
  const test::TemporaryFolder folder;
  const service::ResultStore store(folder.path());
  const service::ContourService contours(solver::trace_contours, store);
  double longest = 0.0, work = 0.0, ended_before = 0.0;
  for (auto _ : state) {
    service::Jobs jobs({2, 8});
    const auto busy = start(jobs, contours, finest_request("torus", true));
    for (const double moment : kMoments) {
      Worker worker;
      const auto job = start(jobs, contours, finest_request(example, certify), &worker);
      jobs.keep(job);
      const auto done = std::make_shared<std::promise<void>>();
      job->wait(&worker, [done](const auto&) { done->set_value(); });
      const clockid_t clock = worker.began.get_future().get();
      std::this_thread::sleep_for(std::chrono::duration<double>(moment));
      if (job->report().ended()) {
        ++ended_before;
        done->get_future().get();
        continue;
      }
      const double worked = seconds_of(clock);
      const auto begin = std::chrono::steady_clock::now();
      jobs.dismiss(job->id());
      done->get_future().get();
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
      longest = std::max(longest, took.count());
      work = std::max(work, worker.ended - worked);
    }
  }
  state.counters["longest_ms"] = 1e3 * longest;
  state.counters["own_ms"] = 1e3 * work;
  state.counters["ended_before"] = ended_before;
}

const bool registered = [] {
  for (const service::Example& example : service::examples())
    for (const bool certify : {false, true}) {
      const std::string name =
          std::string("cancel/") + std::string(example.name) + (certify ? "/certify" : "");
      benchmark::RegisterBenchmark(name.c_str(), cancel, example.name.data(), certify)
          ->Iterations(1)
          ->UseRealTime()
          ->Unit(benchmark::kMillisecond);
    }
  return true;
}();

}  // namespace
}  // namespace caustic::bench
