// Checks of contours of the total irradiance. Failures are reported through gtest.
#pragma once

#include <functional>
#include <vector>

#include "solver/contours.h"
#include "solver/optical_system.h"

namespace caustic::test {

/// Curves of the total of all families of one bounce, with the direct light if asked for.
solver::ContourResult total_of(const solver::OpticalSystem& system, std::vector<double> levels,
                               double chord = 0.0, bool direct = false);

/// Area of {E_total ≥ level} by the polygons, m².
double area_above(const solver::ContourResult& result, double level);

/// Every arc begins where the one before it in its ring ends. `width` of the receiver, m.
void expect_closed_rings(const solver::ContourResult& result, double width);

/// Level arcs and jumps against what a meter reads there, all paths found anew.
void expect_true_of_the_meter(const solver::OpticalSystem& system,
                              const solver::ContourResult& result, bool direct = false);

/// Every path to a few vertices of each curve of the level found anew by the certified method: as
/// many sheets with the same first hits as the meter knows, and on level arcs Σ E_k = level.
/// Returns the number of paths that were proven.
int expect_all_paths_proven(const solver::OpticalSystem& system,
                            const solver::ContourResult& result, int vertices_of_curve = 1);

/// Areas against random points at which E is asked, within four standard deviations. 10⁷ points by
/// ISOCAUSTIC_SAMPLES=10000000 instead of `samples`.
using TotalAt = std::function<double(const geometry::Vec2& q)>;
void expect_areas(const solver::OpticalSystem& system, const solver::ContourResult& result,
                  double chord, const TotalAt& total, int samples = 20000);
/// The same with a light meter.
void expect_areas(const solver::OpticalSystem& system, const solver::ContourResult& result,
                  double chord, int samples = 20000, bool direct = false);

}  // namespace caustic::test
