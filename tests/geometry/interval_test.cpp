// Intervals hold what they promise to hold, in 50-digit arithmetic, and not much more.
#include "geometry/interval.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <functional>

#include "geometry/linear.h"
#include "tests/support/random.h"
#include "tests/support/thorough.h"

namespace caustic::geometry {
namespace {

using test::Random;
using test::thorough;
using Real = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>,
                                           boost::multiprecision::et_off>;

constexpr double kTiny = std::numeric_limits<double>::denorm_min();
constexpr double kHuge = std::numeric_limits<double>::max();

// Numbers of all sizes, often zero, often at the ends of what a double can be.
double any_number(Random& random) {
  switch (random.index(8)) {
    case 0:
      return 0.0;
    case 1:
      return random.sign() * std::ldexp(random.uniform(0.5, 1.0), random.index(2098) - 1074);
    case 2:
      return random.sign() * kTiny * random.index(4);
    case 3:
      return random.sign() * random.index(4);
    default:
      return random.sign() * random.log_uniform(1e-3, 1e3);
  }
}

Interval any_interval(Random& random) {
  const double a = any_number(random), b = random.index(5) == 0 ? a : any_number(random);
  return {std::min(a, b), std::max(a, b)};
}

double any_point(const Interval& a, Random& random) {
  switch (random.index(4)) {
    case 0:
      return a.lo;
    case 1:
      return a.hi;
    default:
      return std::clamp(a.lo + random.uniform() * (0.5 * a.hi - 0.5 * a.lo) * 2.0, a.lo, a.hi);
  }
}

bool holds(const Interval& a, const Real& x) {
  return !a.empty() && Real(a.lo) <= x && x <= Real(a.hi);
}

/// Ends of the result for one point lie within `ulps` units of it.
void expect_tight(const Interval& a, double ulps) {
  if (!a.bounded() || a.magnitude() < 1e-300) return;
  EXPECT_LE(a.width(), ulps * kEpsilon * a.magnitude()) << a.lo << " " << a.hi;
}

TEST(Rounding, NeighboursLieOutside) {
  Random random(1);
  for (int i = 0; i < thorough(20000, 1000); ++i) {
    const double c = any_number(random);
    EXPECT_LE(rounding::below(c), std::nextafter(c, -kInfinity)) << c;
    EXPECT_GE(rounding::above(c), std::nextafter(c, kInfinity)) << c;
    EXPECT_GE(rounding::below(c), c - 2.0 * (std::nextafter(std::abs(c), kInfinity) - std::abs(c)));
  }
  EXPECT_EQ(rounding::below_sum(0.0), 0.0);
}

TEST(Interval, ArithmeticHoldsTheExactResult) {
  Random random(2);
  for (int i = 0; i < thorough(40000, 1000); ++i) {
    const Interval a = any_interval(random), b = any_interval(random);
    const double x = any_point(a, random), y = any_point(b, random);
    const Real X(x), Y(y);
    EXPECT_TRUE(holds(a + b, X + Y)) << x << " + " << y;
    EXPECT_TRUE(holds(a - b, X - Y)) << x << " - " << y;
    EXPECT_TRUE(holds(a * b, X * Y)) << x << " * " << y;
    EXPECT_TRUE(holds(x * b, X * Y)) << x << " * " << y;
    if (y != 0.0) {
      EXPECT_TRUE(holds(a / b, X / Y)) << x << " / " << y;
    }
    EXPECT_TRUE(holds(sqr(a), X * X)) << x;
    EXPECT_TRUE(holds(abs(a), boost::multiprecision::abs(X))) << x;
    EXPECT_TRUE(holds(-a, -X)) << x;
    EXPECT_TRUE(holds(hull(a, b), X) && holds(hull(a, b), Y));
    EXPECT_EQ(holds(intersection(a, b), X), b.contains(x));
    for (const int n : {-3, -2, -1, 0, 1, 2, 3, 4, 5, 7, 12, 31}) {
      if (x == 0.0 && n < 0) continue;
      EXPECT_TRUE(holds(power(a, n), boost::multiprecision::pow(X, n))) << x << " ^ " << n;
    }
  }
}

TEST(Interval, FunctionsHoldTheExactResult) {
  Random random(3);
  for (int i = 0; i < thorough(4000, 200); ++i) {
    const Interval a = any_interval(random);
    const double x = any_point(a, random);
    const Real X(x);
    if (x >= 0.0) {
      EXPECT_TRUE(holds(sqrt(a), sqrt(X))) << x;
    }
    if (x > 0.0) {
      EXPECT_TRUE(holds(log(a), log(X))) << x;
      for (const double p : {0.5, 1.0 / 3.0, 2.5, -0.5, -1.25, 0.0}) {
        EXPECT_TRUE(holds(power(a, p), pow(X, Real(p)))) << x << " ^ " << p;
      }
    }
    if (std::abs(x) < 1e4) {
      EXPECT_TRUE(holds(exp(a), exp(X))) << x;
    }
    if (std::abs(x) < 1e15) {
      EXPECT_TRUE(holds(sin(a), sin(X))) << x;
      EXPECT_TRUE(holds(cos(a), cos(X))) << x;
    }
  }
}

// Extremes of the waves inside, at an end and just outside of the interval.
TEST(Interval, WavesReachTheirExtremes) {
  Random random(4);
  for (int i = 0; i < thorough(3000, 150); ++i) {
    const double width = random.log_uniform(1e-8, 10.0), lo = random.uniform(-20.0, 20.0);
    const Interval a{lo, lo + width};
    for (const bool cosine : {false, true}) {
      const Interval range = cosine ? cos(a) : sin(a);
      double least = 1.0, most = -1.0;
      for (int k = 0; k <= 200; ++k) {
        const double t = std::min(lo + width * k / 200.0, a.hi),
                     f = cosine ? std::cos(t) : std::sin(t);
        EXPECT_TRUE(range.contains(f));
        least = std::min(least, f);
        most = std::max(most, f);
      }
      const double spacing = width / 200.0;
      EXPECT_GT(range.lo, least - 0.5 * spacing * spacing - 1e-14);
      EXPECT_LT(range.hi, most + 0.5 * spacing * spacing + 1e-14);
    }
  }
}

TEST(Interval, PointsGiveTightResults) {
  Random random(5);
  for (int i = 0; i < thorough(3000, 150); ++i) {
    const double x = random.log_uniform(1e-3, 1e2),
                 y = random.sign() * random.log_uniform(1e-3, 1e3);
    const Interval a(x), b(y);
    for (const Interval& r : {a + b, a - b, a * b, a / b, sqr(a), sqrt(a)}) expect_tight(r, 3.0);
    for (const Interval& r : {exp(a), log(a), power(a, 0.3), power(a, -2.7)}) expect_tight(r, 6.0);
    EXPECT_LE(sin(b).width(), 6.0 * kEpsilon);
    EXPECT_LE(cos(b).width(), 6.0 * kEpsilon);
    for (const int n : {2, 3, 4, 5, -1, -2, 8}) expect_tight(power(a, n), 4.0 * std::abs(n));
  }
}

TEST(Interval, SignsAreKept) {
  // What is not negative stays so: a square root after it is defined everywhere.
  const Interval a{0.0, 2.0}, s{-1.0, 1.0};
  for (const Interval& r : {sqr(s), sqr(a), a * a, a + sqr(s), a / Interval(1.0, 2.0), power(s, 4),
                            abs(s), sqrt(a), exp(Interval(-800.0, 0.0)), power(a, 1.5)}) {
    EXPECT_EQ(r.lo, 0.0);
  }
  EXPECT_EQ(cos(Interval(-1e-9, 1e-9)).hi, 1.0);
  const Interval cube = power(Interval(-1.0, 2.0), 3);
  EXPECT_NEAR(cube.lo, -1.0, 1e-15);
  EXPECT_NEAR(cube.hi, 8.0, 1e-14);
}

TEST(Interval, PartsOfADomain) {
  EXPECT_EQ(sqrt(Interval(-1.0, 4.0)).lo, 0.0);
  EXPECT_EQ(log(Interval(-1.0, 1.0)).lo, -kInfinity);
  EXPECT_NEAR(log(Interval(-1.0, 1.0)).hi, 0.0, 1e-300);
  EXPECT_EQ(power(Interval(-2.0, 4.0), 0.5).lo, 0.0);
  EXPECT_TRUE((1.0 / Interval(-1.0, 1.0)).contains(Interval::whole()));
  const Interval above = 1.0 / Interval(0.0, 2.0), below = 1.0 / Interval(-2.0, 0.0);
  EXPECT_NEAR(above.lo, 0.5, 1e-15);
  EXPECT_EQ(above.hi, kInfinity);
  EXPECT_EQ(below.lo, -kInfinity);
  EXPECT_NEAR(below.hi, -0.5, 1e-15);
}

TEST(Interval, EmptyStaysEmpty) {
  const Interval empty = Interval::empty_set(), one(1.0), zero(0.0);
  for (const Interval& r : {sqrt(Interval(-2.0, -1.0)),
                            log(Interval(-2.0, 0.0)),
                            power(Interval(-2.0, -1.0), 0.5),
                            power(zero, -0.5),
                            one / zero,
                            empty + one,
                            one - empty,
                            empty * one,
                            one * empty,
                            2.0 * empty,
                            one / empty,
                            empty / one,
                            sqr(empty),
                            abs(empty),
                            sqrt(empty),
                            exp(empty),
                            log(empty),
                            sin(empty),
                            cos(empty),
                            power(empty, 2),
                            power(empty, 3),
                            power(empty, -1),
                            power(empty, 1.5),
                            -empty,
                            intersection(empty, one),
                            intersection(one, zero)}) {
    EXPECT_TRUE(r.empty());
    EXPECT_FALSE(r.contains_zero());
    EXPECT_FALSE(r.contains(1.0));
  }
  EXPECT_FALSE(hull(empty, one).empty());
}

TEST(Interval, OverflowAndInfinitySayNothing) {
  const Interval huge(0.5 * kHuge, kHuge), whole = Interval::whole();
  EXPECT_TRUE((huge + huge).contains(kHuge));
  EXPECT_TRUE((huge * huge).contains(kHuge));
  EXPECT_TRUE((huge - huge).contains(0.0));
  EXPECT_TRUE(sqr(huge).contains(kHuge));
  EXPECT_TRUE(power(huge, 5).contains(kHuge));
  EXPECT_TRUE(exp(Interval(1000.0)).contains(kHuge));
  EXPECT_TRUE((whole - whole).contains(whole));
  EXPECT_TRUE((whole * Interval(0.0)).contains(0.0));
  EXPECT_TRUE((whole * whole).contains(whole));
  EXPECT_TRUE((Interval(0.0, kInfinity) * Interval(0.0, 1.0)).contains(Interval(0.0, kInfinity)));
  EXPECT_TRUE((whole / whole).contains(whole));
  EXPECT_EQ(sin(whole).width(), 2.0);
  EXPECT_EQ(exp(whole).lo, 0.0);
}

}  // namespace
}  // namespace caustic::geometry
