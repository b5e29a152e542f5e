// Predictor of the curve: one step of ẋ = t(x), |t| = 1, by an embedded Runge–Kutta pair of order
// 5(4) with dense output (Dormand & Prince, as Boost.Odeint has it).
// Measured (tests/bench/README.md): at the accuracy that Newton's method wants, corrected after each step,
// 193 evaluations a loop leave 9e-8 m, Adams–Bashforth–Moulton of order 8 leaves 4e-6 m with 205.
#pragma once

#include <memory>

#include "geometry/linear.h"

namespace caustic::solver {

/// The right-hand side. Returns false where there is no direction; the step then fails.
class DirectionField {
 public:
  virtual ~DirectionField() = default;
  virtual bool direction(const geometry::Point& x, geometry::Vec3& t) = 0;
  /// The direction at the end of a step. That of a corrected point next to x will do as well: error
  /// estimate and dense output feel the difference in a higher order only.
  virtual bool direction_at_end(const geometry::Point& x, geometry::Vec3& t) {
    return direction(x, t);
  }
};

class Predictor {
 public:
  explicit Predictor(DirectionField& field);
  ~Predictor();

  struct Step {
    bool usable;   ///< every stage had a direction
    geometry::Point end;
    double error;  ///< estimated error of `end`, m
  };
  /// A step of arc length ds > 0 from x0, where the direction is t0.
  Step attempt(const geometry::Point& x0, const geometry::Vec3& t0, double ds);
  /// The point at fraction w in [0, 1] of the last usable step, to fourth order.
  geometry::Point at(double w) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace caustic::solver
