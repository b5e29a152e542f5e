// A mirror with a dimple so small that subdivision does not see it.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>

#include "geometry/expression/field.h"
#include "geometry/surface.h"
#include "tests/support/scenes.h"

namespace caustic::test {

using namespace solver;

// A shallow bowl of which one dimple, half a millimetre wide, focuses the light a little: at height
// 1 above it a loop of the level is a thousandth of the receiver wide, and nothing else reaches it.
struct Dimple {
  static constexpr double kX = 0.2371, kY = -0.1193, kWidth = 4e-4, kDepth = 0.1 * kWidth * kWidth;
  OpticalSystem system;
};
inline Dimple dimple() {
  char text[200];
  std::snprintf(text, sizeof text,
                "z-0.02*x^2-0.03*y^2-0.01*x^3+%.17g*exp(-((x-%.17g)^2+(y-%.17g)^2)*%.17g)",
                Dimple::kDepth, Dimple::kX, Dimple::kY, 0.5 / (Dimple::kWidth * Dimple::kWidth));
  const auto shape =
      geometry::make_expression(geometry::read_expression(text, 1.0),
                                {{-0.5, -0.5, -0.1}, {0.5, 0.5, 0.1}}, geometry::Pose());
  EXPECT_TRUE(shape.surface) << shape.fault;
  return {one_mirror(CollimatedLight{-Vec3::UnitZ(), 1.0}, shape.surface,
                     floor_at({0, 0, 1}, 1.0, 1.0))};
}

}  // namespace caustic::test
