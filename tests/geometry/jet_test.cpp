#include "geometry/jet.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace caustic::geometry {
namespace {

// The jet of c0 + c1 s + c2 t + ½c3 s² + c4 st + ½c5 t² at the origin is its coefficients.
double at(const Jet& j, double s, double t) {
  return j.v + j.s * s + j.t * t + 0.5 * j.ss * s * s + j.st * s * t + 0.5 * j.tt * t * t;
}

// Largest difference between a jet and the second-order expansion of f, by differences.
template <class F>
void expect_jet(const Jet& jet, const F& f, double tolerance) {
  const double h = 1e-3;
  const auto second = [&](double ds, double dt) {
    return (16.0 * (f(ds, dt) + f(-ds, -dt)) - f(2 * ds, 2 * dt) - f(-2 * ds, -2 * dt) -
            30.0 * f(0, 0)) / (12.0 * h * h);
  };
  EXPECT_NEAR(jet.v, f(0, 0), 1e-14);
  EXPECT_NEAR(jet.s, (8 * (f(h, 0) - f(-h, 0)) - f(2 * h, 0) + f(-2 * h, 0)) / (12 * h), tolerance);
  EXPECT_NEAR(jet.t, (8 * (f(0, h) - f(0, -h)) - f(0, 2 * h) + f(0, -2 * h)) / (12 * h), tolerance);
  EXPECT_NEAR(jet.ss, second(h, 0), 1e3 * tolerance);
  EXPECT_NEAR(jet.tt, second(0, h), 1e3 * tolerance);
  // Along the diagonal: f_ss + 2 f_st + f_tt.
  EXPECT_NEAR(jet.ss + 2.0 * jet.st + jet.tt, second(h, h), 4e3 * tolerance);
}

TEST(Jet, ArithmeticIsDifferentiation) {
  test::Random random(1);
  const auto any = [&] {
    Jet j{};
    for (double* c : {&j.v, &j.s, &j.t, &j.ss, &j.st, &j.tt}) *c = random.uniform(-1.0, 1.0);
    return j;
  };
  for (int i = 0; i < 200; ++i) {
    const Jet a = any();
    Jet b = any();
    b.v = random.sign() * random.uniform(0.7, 2.0);
    const auto f = [&](double s, double t) { return at(a, s, t); };
    const auto g = [&](double s, double t) { return at(b, s, t); };
    expect_jet(a + b, [&](double s, double t) { return f(s, t) + g(s, t); }, 1e-8);
    expect_jet(a - b, [&](double s, double t) { return f(s, t) - g(s, t); }, 1e-8);
    expect_jet(-2.5 * a, [&](double s, double t) { return -2.5 * f(s, t); }, 1e-8);
    expect_jet(a * b, [&](double s, double t) { return f(s, t) * g(s, t); }, 1e-8);
    expect_jet(a / b, [&](double s, double t) { return f(s, t) / g(s, t); }, 1e-8);
    // (a/b)·b = a, all six numbers.
    const Jet back = (a / b) * b;
    EXPECT_NEAR(back.ss, a.ss, 1e-13);
    EXPECT_NEAR(back.st, a.st, 1e-13);
    EXPECT_NEAR(back.tt, a.tt, 1e-13);
  }
}

}  // namespace
}  // namespace caustic::geometry
