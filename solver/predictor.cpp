#include "solver/predictor.h"

#include <Eigen/Core>
// Odeint's algebra for Eigen wants Eigen first.
#include <boost/numeric/odeint/algebra/vector_space_algebra.hpp>
#include <boost/numeric/odeint/external/eigen/eigen_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>

namespace caustic::solver {

using geometry::Point;
using geometry::Vec3;
namespace odeint = boost::numeric::odeint;

struct Predictor::State {
  using Stepper = odeint::runge_kutta_dopri5<Vec3, double, Vec3, double, odeint::vector_space_algebra>;

  explicit State(DirectionField& f) : field(f) {}

  DirectionField& field;
  Stepper stepper;
  Point begin, end;
  Vec3 t_begin, t_end;
  double ds = 0.0;
};

Predictor::Predictor(DirectionField& field) : state_(std::make_unique<State>(field)) {}
Predictor::~Predictor() = default;

Predictor::Step Predictor::attempt(const Point& x0, const Vec3& t0, double ds) {
  State& s = *state_;
  bool usable = true;
  const auto rhs = [&](const Vec3& x, Vec3& t, double) {
    // The last stage is asked for at the step's own end.
    const bool at_end = &x == &s.end;
    usable = usable && (at_end ? s.field.direction_at_end(x, t) : s.field.direction(x, t));
    if (!usable) t = t0;
  };
  Vec3 error = Vec3::Zero();
  s.begin = x0;
  s.t_begin = t0;
  s.ds = ds;
  s.stepper.do_step(rhs, x0, t0, 0.0, s.end, s.t_end, ds, error);
  return {usable && s.end.allFinite(), s.end, error.norm()};
}

Point Predictor::at(double w) const {
  const State& s = *state_;
  Point x;
  // The last arguments are where the step began and ended; the stages are kept in the stepper.
  s.stepper.calc_state(w * s.ds, x, s.begin, s.t_begin, 0.0, s.end, s.t_end, s.ds);
  return x;
}

}  // namespace caustic::solver
