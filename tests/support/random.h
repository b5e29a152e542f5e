// Seeded random numbers, the same on every platform.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "geometry/linear.h"

namespace caustic::test {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// Uniform in [lo, hi).
  double uniform(double lo = 0.0, double hi = 1.0) {
    return lo + (hi - lo) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  /// Uniform in the exponent, with the sign of `lo`.
  double log_uniform(double lo, double hi) {
    return std::copysign(std::exp(uniform(std::log(std::abs(lo)), std::log(std::abs(hi)))), lo);
  }
  int index(int n) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(n)); }
  double sign() { return index(2) == 0 ? 1.0 : -1.0; }
  geometry::Vec3 in_cube(double half) {
    const double x = uniform(-half, half), y = uniform(-half, half), z = uniform(-half, half);
    return {x, y, z};
  }
  geometry::Direction direction() {
    const double z = uniform(-1.0, 1.0), angle = uniform(0.0, 2.0 * geometry::kPi);
    const double r = std::sqrt(1.0 - z * z);
    return geometry::Direction(r * std::cos(angle), r * std::sin(angle), z).normalized();
  }
  geometry::Mat3 rotation() {
    return Eigen::AngleAxisd(uniform(0.0, geometry::kPi), direction()).toRotationMatrix();
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace caustic::test
