// What holds for every curve of every scene, checked without the tracer's own judgement.
#pragma once

#include <string>
#include <vector>

#include "solver/contours.h"
#include "solver/forward_map.h"

namespace caustic::test {

/// True if no surface stands between the light and x or between x and its arrival: every crossing of
/// both segments tried against every aperture.
bool in_sight(const solver::OpticalSystem& system, const solver::FieldPoint& f);

/// Checks every vertex and end of a result: finite, inside the receiver and the aperture, lit, in
/// sight, on the mirror, E within `tolerance` of the level; arc lengths, ends named after the boundary
/// they lie on. Failures are reported through gtest with `what`.
void expect_sound(const solver::OpticalSystem& system, const solver::ContourResult& result,
                  double tolerance, const std::string& what);

/// Largest distance of the true curve from the polyline: between two vertices the curve is found anew
/// by Newton's method at `samples` places.
double largest_chord_error(const solver::OpticalSystem& system, const solver::Curve& curve,
                           int samples = 5);

/// Connected components of { E = level, sign a = parity } on mirror `surface`, lit on `side`, by
/// marching over an n × n grid on each chart: a brute-force count for comparison. Components in
/// one chart only: give shapes with a single chart that does not wrap around in the scene.
struct GridCount {
  int components = 0;
  std::vector<geometry::Vec2> places;  ///< on the receiver, one for each component
};
GridCount count_on_grid(const solver::OpticalSystem& system, int surface, int side, double level,
                        int parity, int n);

}  // namespace caustic::test
