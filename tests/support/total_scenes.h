// Scenes whose sheets overlap, for tests of the total.
#pragma once

#include "solver/optical_system.h"

namespace caustic::test {

/// A ball of radius 1 m under its lamp, one sheet on the ceiling.
solver::OpticalSystem ball_under_ceiling();

/// Unit cylinder arc |φ| ≤ 60°, height 1, lit by a beam at 45° along x.
solver::OpticalSystem nephroid_ring();

/// Two tilted plates whose patches of light overlap on the ceiling, and what they are made of.
struct Plate {
  geometry::Point middle;
  geometry::Vec3 normal;
  geometry::Vec2 lo, hi;  ///< in x and y
  double reflectance;
};
extern const Plate kPlates[2];
inline const geometry::Point kLampOverPlates(0.1, 0.05, 1.0);
solver::OpticalSystem two_plates();

/// Water with waves across each other, on a floor below where its light has met.
solver::OpticalSystem crossing_waves();

/// The same before its light meets, on a floor of one wave by one wave.
solver::OpticalSystem shallow_crossing_waves();

/// A spherical dish, tilted in a beam, with both of its caustics near the receiver.
solver::OpticalSystem tilted_dish();

/// A torus beside its lamp.
solver::OpticalSystem torus_beside_lamp();

/// The surface x⁴ + y⁴ + z⁴ = x² + y² + z² over the floor that it throws its caustics on.
solver::OpticalSystem cuboid_over_floor();

}  // namespace caustic::test
