#include "tests/stress/scene_run.h"

#include <set>

#include "service/api/problem.h"
#include "tests/stress/checks.h"
#include "tests/stress/random_scene.h"

namespace caustic::stress {
namespace {

// CPU seconds: a request has a limit of two; checks trace the scene again and follow many rays.
constexpr int kToMake = 20, kToTrace = 20, kToCheck = 60;

}  // namespace

json outcome_of(const json& request, std::uint64_t seed, std::uint64_t k, const Thoroughness& how,
                const std::function<void()>& traced) {
  json out = {{"done", true}};
  try {
    const Trial trial = run_trial(request);
    traced();
    const Oracle oracle(request["scene"]);
    Subject subject{trial, oracle, seed + k};
    std::set<std::string> codes;
    for (const auto& warning : trial.result.warnings) codes.insert(warning.code);
    out["seconds"] = trial.cpu;
    out["evaluations"] = trial.result.evaluations;
    out["vertices"] = trial.curves.vertices.size();
    out["complete"] = trial.result.complete;
    out["warned"] = is_warned(trial.result);
    out["undecided"] = trial.result.undecided_cells;
    out["codes"] = codes;
    out["asked"] = out["findings"] = json::array();
    for (std::size_t i = 0; i < checks().size(); ++i) {
      const NamedCheck& check = checks()[i];
      // Rarer checks take turns.
      const int one_in = check.one_in * (check.heavy ? how.thinning : 1);
      if (!how.clock && check.run == check_time) continue;
      if (!how.every && one_in > 1 && (k + i) % one_in != 0) continue;
      const double begin = thread_seconds();
      subject.until = begin + how.check_seconds;
      if (const auto found = check.run(subject)) out["findings"].push_back({check.name, *found});
      out["asked"].push_back({check.name, thread_seconds() - begin});
    }
  } catch (const service::ProblemError& error) {
    out["refused"] = service::to_json(error.problem());
  }
  return out;
}

void run_scene(std::uint64_t seed, std::uint64_t k, const Thoroughness& how, const Voice& voice) {
  voice.say({{"making", k}}, kToMake);
  json request = random_request(seed, k);
  request["limits"]["time_ms"] = how.time_ms;
  voice.say({{"request", request}}, kToTrace);
  voice.say(outcome_of(request, seed, k, how,
                       [&] {
                         voice.say({{"traced", true}}, kToCheck);
                       }),
            kToMake);
}

}  // namespace caustic::stress
