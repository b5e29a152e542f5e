// What is fuzzed: each takes any bytes and ends the program if a promise is broken.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace caustic::test {

/// Request heads and bodies: the same requests come out however the bytes are cut, none beyond the
/// limits, none after a refusal.
void fuzz_request(std::string_view bytes);
/// Bodies of every POST: read, or refused with a problem.
void fuzz_scene(std::string_view bytes);
/// Expressions: read, or refused with a fault; what is read has values and enclosures that agree.
void fuzz_expression(std::string_view bytes);
/// A connection: whatever is sent, the answer is no 500, and its JSON can be read.
void fuzz_service(std::string_view bytes);

struct FuzzTarget {
  const char* name;
  void (*run)(std::string_view);
  std::vector<std::string> (*seeds)();
  long mutations;  ///< so many belong into the suite
};
const std::vector<FuzzTarget>& fuzz_targets();

}  // namespace caustic::test
