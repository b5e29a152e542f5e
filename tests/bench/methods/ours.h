// What is asked of this program, by the method that is it and by the truth.
#pragma once

#include "tests/bench/methods/method.h"

namespace caustic::bench {

/// Chord in widths of the window.
solver::ContourRequest request_of(const Scene& scene, solver::Measure measure, double chord);

/// Level arcs and jumps: what a plot of the irradiance shows. The receiver's edge is drawn by none
/// of the other methods.
inline bool is_drawn(const solver::Curve& curve) {
  return curve.kind == solver::CurveKind::isolux || curve.kind == solver::CurveKind::jump;
}
test::Line line_of(const solver::Curve& curve);
std::size_t level_of(const Scene& scene, double level);

}  // namespace caustic::bench
