// Many scenes, each in a child process: one that crashes or hangs is a failure of that scene and
// not the end of the run.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>

namespace caustic::stress {

/// What a child says on its way; the last thing said tells what it died of.
class Voice {
 public:
  explicit Voice(int descriptor) : descriptor_(descriptor) {}
  /// A line to the parent. From then on so many seconds of CPU are allowed until the next.
  void say(const nlohmann::json& line, int seconds) const;

 private:
  int descriptor_;
};

struct BatchPlan {
  std::uint64_t first, count;
  int jobs = 1;             ///< children at once
  std::uint64_t size = 25;  ///< scenes of a child
  double minutes = 1e9;     ///< after which no child is started
};

/// In a child: says what it finds about scene k.
using Work = std::function<void(std::uint64_t k, const Voice& voice)>;
/// In the parent, for each line; and for each scene whose child died in it, with {"died": why}.
using Listener = std::function<void(std::uint64_t k, const nlohmann::json& line)>;

void run_batches(const BatchPlan& plan, const Work& work, const Listener& listener);

}  // namespace caustic::stress
