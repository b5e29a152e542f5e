// Newton's method back to a curve { g = 0, f = 0 }, and to its end { g = 0, f = 0, h = 0 }.
#pragma once

#include <optional>

#include "solver/domain.h"
#include "solver/evaluator.h"
#include "solver/level_function.h"

namespace caustic::solver {

constexpr double kUndetermined = 1e-4;

struct CorrectorOptions {
  /// Accept once the residual of the level function is below this (or what rounding allows)
  double residual = 1e-11;
  /// and its distance from the curve, by Newton's next step, is below this, m.
  double position = geometry::kInfinity;
  /// Give up if the point moves further than this from where it started, m.
  double trust = geometry::kInfinity;
};

/// The point of the curve next to x, by steps of least length along the surface (S10); nothing if
/// Newton's method leaves the trust region or does not converge, or where rounding of x alone moves
/// the residual by more than kUndetermined: next to points where all levels meet. Later hits are
/// those next to the hits `near`, if given.
std::optional<FieldPoint> correct(Evaluator& evaluate, const LevelFunction& f, const Point& x,
                                  const CorrectorOptions& options, const Hit* near = nullptr);
/// The same from a point of the surface that has been evaluated.
std::optional<FieldPoint> correct(Evaluator& evaluate, const LevelFunction& f,
                                  const FieldPoint& start, const CorrectorOptions& options);

/// The point next to x where both functions vanish.
std::optional<FieldPoint> correct_at_end(Evaluator& evaluate, const LevelFunction& f,
                                         const LevelFunction& h, const Point& x,
                                         const CorrectorOptions& options,
                                         const Hit* near = nullptr);

}  // namespace caustic::solver
