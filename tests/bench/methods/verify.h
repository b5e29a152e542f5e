// How true the truth is: against closed forms, and against 50 digits.
#pragma once

#include <ostream>

#include "tests/bench/methods/scene.h"

namespace caustic::bench {

inline constexpr const char* kVerifyColumns =
    "scene,curves,chord,seconds,vertices,proven complete,undecided cells,against,points,farthest";

/// Distances in widths of the window.
void verify(const Scene& scene, std::ostream& out);

}  // namespace caustic::bench
