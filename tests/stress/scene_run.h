// One scene: made, traced, checked.
#pragma once

#include <cstdint>

#include "tests/stress/batches.h"

namespace caustic::stress {

/// How much is done about one scene.
struct Thoroughness {
  double check_seconds = 1.0;  ///< CPU time after which one check looks at no further place
  int thinning = 1;            ///< heavy checks are asked so many times more rarely
  double time_ms = 1000.0;     ///< of the request
  bool clock = true;           ///< false: how long it takes is no matter
  bool every = false;          ///< all checks, in no turn

  static Thoroughness full() { return {}; }
  /// For a suite: the scenes are the same, fewer places of each are looked at.
  static Thoroughness quick() { return {0.002, 8, 30.0, false}; }
  /// Of a request that somebody brings: everything.
  static Thoroughness every_check() { return {.check_seconds = 1e9, .every = true}; }
};

/// Says {"request": …}, {"traced": true} and {"done": true, …} of report.h.
void run_scene(std::uint64_t seed, std::uint64_t k, const Thoroughness& how, const Voice& voice);
/// What report.h adds up, of any request.
nlohmann::json outcome_of(const nlohmann::json& request, std::uint64_t seed, std::uint64_t k,
                          const Thoroughness& how, const std::function<void()>& traced);

}  // namespace caustic::stress
