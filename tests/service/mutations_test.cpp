// Mutated requests: some thousand here, a million by `./dev fuzz`.
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/fuzz/mutations.h"
#include "tests/fuzz/targets.h"
#include "tests/support/thorough.h"

namespace caustic::test {
namespace {

class Mutated : public testing::TestWithParam<FuzzTarget> {};

/// A target that finds a promise broken ends the program, and says which.
TEST_P(Mutated, keep_every_promise) {
  const char* wanted = std::getenv("ISOCAUSTIC_MUTATIONS");
  const long all = GetParam().mutations;
#if defined(__SANITIZE_THREAD__)
  const long few = all / 20;  // in one thread
#else
  const long few = all / 5;
#endif
  const long count = wanted ? std::atol(wanted) : kSanitized ? few : all;
  const std::vector<std::string> seeds = GetParam().seeds();
  for (const std::string& seed : seeds) GetParam().run(seed);
  Mutations mutations(20261122);
  for (long i = 0; i < count; ++i) GetParam().run(mutations.next(seeds));
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Mutated, testing::ValuesIn(fuzz_targets()),
                         [](const auto& target) { return target.param.name; });

}  // namespace
}  // namespace caustic::test
