// What holds for every curve of every scene, checked without the tracer's own judgement.
#pragma once

#include <string>
#include <vector>

#include "solver/contours.h"
#include "solver/forward_map.h"

namespace caustic::test {

/// True if no surface stands between the light, the path's hits and its arrival: every crossing of
/// each segment tried against every aperture.
bool in_sight(const solver::OpticalSystem& system, const solver::FieldPoint& f, int hops = 1);

/// Checks every vertex and end of a result: finite, inside the receiver and the aperture, lit, in
/// sight, on the mirror, E within `tolerance` of the level; arc lengths, ends named after the
/// boundary they lie on. Failures are reported through gtest with `what`.
void expect_sound(const solver::OpticalSystem& system, const solver::ContourResult& result,
                  double tolerance, const std::string& what);

/// Largest distance of the true curve from the polyline: between two vertices the curve is found
/// anew by Newton's method at `samples` places.
double largest_chord_error(const solver::OpticalSystem& system, const solver::Curve& curve,
                           int samples = 5);

/// Places of { E = level, sign a = parity } on mirror `surface` lit on `side`:
/// changes of sign on the edges of an n × n grid on each chart, bisected. What a complete trace
/// passes.
std::vector<solver::FieldPoint> points_on_grid(const solver::OpticalSystem& system, int surface,
                                               int side, double level, int parity, int n);

}  // namespace caustic::test
