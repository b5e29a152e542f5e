// Boost.Odeint's steppers as predictors on one closed isolux curve: evaluations of the tangent
// field for one loop against the error, (a) of the loop's end if nothing is corrected, (b) of the
// worst step if Newton's method brings every point back to the curve, as tracing does. Argument:
// steps in the loop.
#include <benchmark/benchmark.h>

#include <Eigen/Core>
// Odeint's algebra for Eigen wants Eigen first.
#include <algorithm>
#include <boost/numeric/odeint/algebra/vector_space_algebra.hpp>
#include <boost/numeric/odeint/external/eigen/eigen_algebra.hpp>
#include <boost/numeric/odeint/stepper/adams_bashforth_moulton.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_cash_karp54.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <cmath>
#include <stdexcept>

#include "solver/corrector.h"
#include "solver/predictor.h"
#include "tests/bench/scenes.h"

namespace caustic::bench {
namespace {

namespace odeint = boost::numeric::odeint;
using geometry::Point;
using geometry::Vec3;
template <template <class...> class Stepper>
using OnVectors = Stepper<Vec3, double, Vec3, double, odeint::vector_space_algebra>;
using Start = OnVectors<odeint::runge_kutta_fehlberg78>;
template <std::size_t Steps>
using Multistep = odeint::adams_bashforth_moulton<Steps, Vec3, double, Vec3, double,
                                                  odeint::vector_space_algebra>;

// ẋ = t(x) on one closed curve of the convex ellipsoid's scene.
class Loop {
 public:
  auto field() {
    return [this](const Vec3& x, Vec3& t, double) {
      ++evaluations;
      t = level_.tangent(map_.evaluate(x));
    };
  }

  Loop() : scene_(convex_ellipsoid()), map_(scene_.system, 0, 1) {
    for (const auto& curve : solver::trace_contours(scene_.system, scene_.request).curves) {
      if (!curve.closed || curve.length < 6.0) continue;
      level_ = solver::LevelFunction::isolux(curve.level, curve.parity);
      start = curve.vertices.front().x;
      for (std::size_t i = 0; i < curve.vertices.size(); ++i) {
        const Point& next = curve.vertices[(i + 1) % curve.vertices.size()].x;
        length += (next - curve.vertices[i].x).norm();
      }
      break;
    }
    if (length == 0.0) throw std::runtime_error("no closed curve");
    // The length at which a fine integration comes back to its start.
    for (int i = 0; i < 3; ++i) {
      Start stepper;
      Point x = start;
      const int n = 2000;
      for (int k = 0; k < n; ++k) stepper.do_step(field(), x, 0.0, length / n);
      Vec3 t;
      field()(start, t, 0.0);
      length += t.dot(start - x);
    }
    evaluations = 0;
  }

  Point corrected(const Point& x) {
    solver::Budget budget(1e9, 1u << 30, nullptr);
    solver::Evaluator evaluate(map_, budget);
    const auto f = solver::correct(evaluate, level_, x, {1e-12, 1e-13});
    if (!f) throw std::runtime_error("off the curve");
    return f->x;
  }

  Point start = Point::Zero();
  double length = 0.0;
  std::size_t evaluations = 0;

 private:
  SceneRequest scene_;
  solver::ForwardMap map_;
  solver::LevelFunction level_;
};

template <class Stepper>
struct OneStep {
  static constexpr int kStartSteps = 0;
  void begin(Loop&, Point&, double) {}
  void step(Loop& loop, Point& x, double ds) { stepper.do_step(loop.field(), x, 0.0, ds); }
  void moved() {
    if constexpr (requires { stepper.reset(); }) stepper.reset();  // what it keeps of the last step
  }
  Stepper stepper;
};

template <std::size_t Steps>
struct ManySteps {
  static constexpr int kStartSteps = Steps - 1;
  void begin(Loop& loop, Point& x, double ds) {
    double s = 0.0;
    stepper.initialize(Start(), loop.field(), x, s, ds);
  }
  void step(Loop& loop, Point& x, double ds) { stepper.do_step(loop.field(), x, 0.0, ds); }
  void moved() {}  // its history stays as it was: off the curve by what was corrected
  Multistep<Steps> stepper;
};

template <class Method>
void predictor(benchmark::State& state) {
  Loop loop;
  const int n = static_cast<int>(state.range(0));
  const double ds = loop.length / n;
  double closing = 0.0, worst = 0.0;
  for (auto _ : state) {
    loop.evaluations = 0;
    Method method;
    Point x = loop.start;
    method.begin(loop, x, ds);
    for (int k = Method::kStartSteps; k < n; ++k) method.step(loop, x, ds);
    closing = (x - loop.start).norm();
  }
  state.counters["evaluations"] = static_cast<double>(loop.evaluations);
  state.counters["closing_error"] = closing;

  Method method;
  Point x = loop.start;
  method.begin(loop, x, ds);
  for (int k = Method::kStartSteps; k < n; ++k) {
    method.step(loop, x, ds);
    const Point back = loop.corrected(x);
    worst = std::max(worst, (back - x).norm());
    x = back;
    method.moved();
  }
  state.counters["step_error"] = worst;
}

// solver/predictor.h as tracing uses it: steps by the embedded error, corrected after each. The
// argument is −log10 of the error allowed per unit of arc.
void controlled(benchmark::State& state) {
  struct Field final : solver::DirectionField {
    explicit Field(Loop& l) : loop(l) {}
    bool direction(const Point& x, Vec3& t) override {
      loop.field()(x, t, 0.0);
      return true;
    }
    Loop& loop;
  };
  Loop loop;
  Field field(loop);
  const double tolerance = std::pow(10.0, -static_cast<double>(state.range(0)));
  double worst = 0.0;
  int steps = 0;
  std::size_t evaluations = 0;
  for (auto _ : state) {
    solver::Predictor predictor(field);
    Point x = loop.start;
    double ds = 0.01 * loop.length, s = 0.0;
    steps = 0;
    worst = 0.0;
    loop.evaluations = 0;
    while (s < loop.length) {
      Vec3 t;
      field.direction(x, t);
      --loop.evaluations;  // the corrector has it already
      const auto step = predictor.attempt(x, t, ds);
      const double factor = 0.9 * std::pow(tolerance * ds / step.error, 0.2);
      if (step.error <= tolerance * ds) {
        x = loop.corrected(step.end);
        worst = std::max(worst, (step.end - x).norm());
        s += ds;
        ++steps;
      }
      ds *= std::clamp(factor, 0.2, 3.0);
    }
    evaluations = loop.evaluations;
  }
  state.counters["steps"] = steps;
  state.counters["evaluations"] = static_cast<double>(evaluations);
  state.counters["step_error"] = worst;
}

#define STEPS RangeMultiplier(2)->Range(16, 256)->Unit(benchmark::kMicrosecond)
BENCHMARK(predictor<OneStep<OnVectors<odeint::runge_kutta4>>>)->Name("predictor/rk4")->STEPS;
BENCHMARK(predictor<OneStep<OnVectors<odeint::runge_kutta_cash_karp54>>>)
    ->Name("predictor/cash_karp54")
    ->STEPS;
BENCHMARK(predictor<OneStep<OnVectors<odeint::runge_kutta_dopri5>>>)
    ->Name("predictor/dopri5")
    ->STEPS;
BENCHMARK(predictor<ManySteps<5>>)->Name("predictor/abm5")->STEPS;
BENCHMARK(predictor<ManySteps<8>>)->Name("predictor/abm8")->STEPS;
BENCHMARK(controlled)
    ->Name("predictor/dopri5_controlled")
    ->DenseRange(3, 9, 1)
    ->Unit(benchmark::kMicrosecond);
#undef STEPS

}  // namespace
}  // namespace caustic::bench
