// Random requests, skewed to trouble. Each is built along one path of light, from the source over
// its surfaces to the receiver, so that there is something to see; what is trouble is chosen on
// the way.
#pragma once

#include <cstdint>

#include "tests/stress/oracle_scene.h"

namespace caustic::stress {

/// The k-th request of a seed. Some ask the engine first, for critical levels.
json random_request(std::uint64_t seed, std::uint64_t k);

}  // namespace caustic::stress
