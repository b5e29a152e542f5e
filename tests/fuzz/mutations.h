// Seeded changes of what is sound: of bytes, and of JSON that stays JSON.
#pragma once

#include <string>
#include <vector>

#include "tests/support/random.h"

namespace caustic::test {

class Mutations {
 public:
  explicit Mutations(std::uint64_t seed) : random_(seed) {}

  /// One of the seeds, changed in a few places; if it is a request with a body of JSON, the body
  /// may be changed as JSON, with a length that is right.
  std::string next(const std::vector<std::string>& seeds);

 private:
  std::string bytes(std::string text);
  std::string document(const std::string& text);

  Random random_;
};

}  // namespace caustic::test
