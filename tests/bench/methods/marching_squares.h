// Level curves of samples, by VTK: what everybody does.
#pragma once

#include <functional>
#include <vector>

#include "tests/bench/methods/method.h"

namespace caustic::bench {

/// Of E at nx × ny points, the window's edges among them; for each level of the scene.
std::vector<std::vector<test::Line>> marching_squares(
    const Scene& scene, int nx, int ny, const std::function<double(const geometry::Vec2&)>& E);

}  // namespace caustic::bench
