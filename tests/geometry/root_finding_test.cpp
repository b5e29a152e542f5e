#include "geometry/root_finding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "tests/support/random.h"

namespace caustic::geometry {
namespace {

using test::Random;

constexpr double kEps = std::numeric_limits<double>::epsilon();

// Coefficients in long double, so that the polynomial has these roots to rounding.
Polynomial with_roots(const std::vector<double>& roots, double leading) {
  std::vector<long double> c{leading};
  for (const double r : roots) {
    std::vector<long double> next(c.size() + 1, 0.0L);
    for (std::size_t i = 0; i < c.size(); ++i) {
      next[i + 1] += c[i];
      next[i] -= c[i] * r;
    }
    c = next;
  }
  Polynomial p;
  p.degree = static_cast<int>(roots.size());
  for (int i = 0; i <= p.degree; ++i) p.c[i] = static_cast<double>(c[i]);
  return p;
}

std::vector<double> roots_of(const Polynomial& p, double t0, double t1) {
  std::vector<double> found;
  real_roots(p, t0, t1, found);
  EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
  EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end()) << "listed twice";
  return found;
}

// How far rounded coefficients move a simple root: ε Σ|c_i t^i| / |p'(t)|.
double conditioning(const Polynomial& p, double t) {
  double sum = 0.0;
  for (int i = p.degree; i >= 0; --i) sum = sum * std::abs(t) + std::abs(p.c[i]);
  return kEps * sum / std::abs(p.derivative()(t));
}

TEST(RealRoots, FindsKnownRootsToTheirConditioning) {
  Random random(1);
  for (int degree = 1; degree <= 4; ++degree) {
    for (int i = 0; i < 3000; ++i) {
      std::vector<double> roots;
      for (int k = 0; k < degree; ++k) roots.push_back(random.uniform(-3.0, 3.0));
      std::sort(roots.begin(), roots.end());
      double gap = 1.0;
      for (int k = 1; k < degree; ++k) gap = std::min(gap, roots[k] - roots[k - 1]);
      if (gap < 1e-4) continue;
      const Polynomial p = with_roots(roots, random.sign() * random.log_uniform(1e-8, 1e8));
      const auto found = roots_of(p, -5.0, 5.0);
      ASSERT_EQ(found.size(), roots.size());
      for (int k = 0; k < degree; ++k) {
        EXPECT_LT(std::abs(found[k] - roots[k]), 4.0 * conditioning(p, roots[k]) + kEps);
      }
    }
  }
}

TEST(RealRoots, KeepsToTheInterval) {
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const int degree = 1 + random.index(4);
    std::vector<double> roots;
    for (int k = 0; k < degree; ++k) roots.push_back(random.uniform(-3.0, 3.0));
    const double t0 = random.uniform(-2.0, 0.0), t1 = random.uniform(0.0, 2.0);
    for (const double t : roots_of(with_roots(roots, 1.0), t0, t1)) {
      EXPECT_GE(t, t0);
      EXPECT_LE(t, t1);
    }
  }
}

TEST(RealRoots, RootsAtTheEndsAreListedOnce) {
  for (const int degree : {1, 2, 3, 4}) {
    std::vector<double> roots{0.0, 1.0, 5.0, -3.0};
    roots.resize(degree);
    const auto found = roots_of(with_roots(roots, 1.0), 0.0, 1.0);
    EXPECT_EQ(found, degree == 1 ? std::vector<double>({0.0}) : std::vector<double>({0.0, 1.0}));
  }
  // A double root at an end, also an end of the last monotone piece.
  for (const auto& roots : {std::vector<double>{1, 1, -5}, {1, 1, -5, 7}, {1, 1, 1}, {1, 1, 1, 1}}) {
    EXPECT_LE(roots_of(with_roots(roots, 1.0), 0.0, 1.0).size(), 1u);
    EXPECT_LE(roots_of(with_roots(roots, 1.0), 1.0, 2.0).size(), 1u);
  }
}

TEST(RealRoots, ClusteredRoots) {
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    const double middle = random.uniform(-1.0, 1.0), gap = random.log_uniform(1e-7, 1e-2);
    const bool four = random.index(2) == 0;
    std::vector<double> roots{middle, middle + gap};
    if (four) roots.insert(roots.end(), {random.uniform(2.0, 3.0), random.uniform(-3.0, -2.0)});
    const Polynomial p = with_roots(roots, 1.0);
    const auto found = roots_of(p, -5.0, 5.0);
    // A pair closer than √ε cannot be told from none; else each is found to its conditioning.
    const double doubt = 8.0 * std::sqrt(4.0 * kEps * (four ? 40.0 : 2.0));
    if (gap > doubt) {
      ASSERT_EQ(found.size(), roots.size()) << "gap " << gap;
      for (const double r : roots) {
        EXPECT_TRUE(std::any_of(found.begin(), found.end(), [&](double t) {
          return std::abs(t - r) < 8.0 * conditioning(p, r) + kEps;
        }));
      }
    } else {
      EXPECT_EQ(found.size() % 2, 0u);
    }
  }
}

TEST(RealRoots, TripleAndQuadrupleRootsAreNotLost) {
  // An odd multiplicity changes sign: it must be found, within the cube root of rounding.
  for (const double r : {0.3, 0.5, -0.7, 1e-3}) {
    for (const double other : {2.0, -2.0}) {
      const auto found = roots_of(with_roots({r, r, r, other}, 1.0), -1.0, 1.0);
      ASSERT_GE(found.size(), 1u);
      for (const double t : found) EXPECT_NEAR(t, r, 3e-5);
      EXPECT_EQ(found.size() % 2, 1u);
    }
  }
}

TEST(RealRoots, CancellationInQuadratics) {
  // t² − 2·10⁸ t + 1: roots 2·10⁸ and 5·10⁻⁹.
  const auto found = roots_of({{1.0, -2e8, 1.0}, 2}, -1.0, 1e9);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_DOUBLE_EQ(found[0], 5e-9);
  EXPECT_DOUBLE_EQ(found[1], 2e8);
  // A leading coefficient that is rounding only.
  const auto line = roots_of({{-1.0, 2.0, 1e-18}, 2}, 0.0, 1.0);
  ASSERT_EQ(line.size(), 1u);
  EXPECT_DOUBLE_EQ(line[0], 0.5);
  const auto both = roots_of({{-1.0, 0.0, 1.0}, 2}, -2.0, 2.0);
  EXPECT_EQ(both, std::vector<double>({-1.0, 1.0}));
  EXPECT_EQ(roots_of({{0.0, 0.0, 1.0}, 2}, -2.0, 2.0).size() % 2, 1u) << "one double root";
}

TEST(RealRoots, DegeneratePolynomialsHaveNoRoots) {
  EXPECT_TRUE(roots_of({{0, 0, 0, 0, 0}, 4}, -1, 1).empty());
  EXPECT_TRUE(roots_of({{1, 0, 0, 0, 0}, 4}, -1, 1).empty());
  EXPECT_EQ(roots_of({{-0.5, 1, 0, 0, 0}, 4}, -1, 1), std::vector<double>({0.5}));
  EXPECT_TRUE(roots_of({{1, 0, 1, 0, 1}, 4}, -9, 9).empty());
}

TEST(BracketedRoot, ConvergesOnAwkwardFunctions) {
  const auto check = [](const auto& f, const auto& df, double a, double b, double expected) {
    int calls = 0;
    const auto counted = [&](double t) { ++calls; return f(t); };
    EXPECT_NEAR(bracketed_root(counted, df, a, b, f(a)), expected, 4e-16 * (1 + std::abs(expected)));
    EXPECT_LT(calls, 120);
  };
  check([](double t) { return std::atan(50.0 * (t - 0.123)); },
        [](double t) { return 50.0 / (1.0 + 2500.0 * (t - 0.123) * (t - 0.123)); }, -10.0, 11.0, 0.123);
  check([](double t) { return std::cbrt(t - 0.25); },
        [](double t) { return 1.0 / (3.0 * std::pow(std::cbrt(t - 0.25), 2)); }, 0.0, 1.0, 0.25);
  check([](double t) { return std::exp(30.0 * t) - 2.0; },
        [](double t) { return 30.0 * std::exp(30.0 * t); }, -5.0, 5.0, std::log(2.0) / 30.0);
  check([](double t) { return t > 0.3 ? 1.0 : -1.0; }, [](double) { return 0.0; }, 0.0, 1.0, 0.3);
}

// c0 + … + c6 t⁶ with enclosures from its monomials, term by term: wide, as they are in practice.
struct Enclosed {
  std::vector<double> c;
  mutable int intervals = 0;

  static double value(const std::vector<double>& p, double t) {
    double sum = 0.0;
    for (std::size_t i = p.size(); i-- > 0;) sum = sum * t + p[i];
    return sum;
  }
  static std::vector<double> derived(const std::vector<double>& p) {
    std::vector<double> d;
    for (std::size_t i = 1; i < p.size(); ++i) d.push_back(static_cast<double>(i) * p[i]);
    return d;
  }
  static Interval range(const std::vector<double>& p, double a, double b) {
    Interval sum{0.0, 0.0};
    double magnitude = 0.0;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const int n = static_cast<int>(i);
      double lo = std::pow(a, n), hi = std::pow(b, n);
      if (lo > hi) std::swap(lo, hi);
      if (n % 2 == 0 && n > 0 && a < 0.0 && b > 0.0) lo = 0.0;
      sum.lo += std::min(p[i] * lo, p[i] * hi);
      sum.hi += std::max(p[i] * lo, p[i] * hi);
      magnitude += std::abs(p[i]) * std::max(std::abs(lo), std::abs(hi));
    }
    return {sum.lo - 4.0 * kEps * magnitude, sum.hi + 4.0 * kEps * magnitude};
  }
  double f(double t) const { return value(c, t); }
  double df(double t) const { return value(derived(c), t); }
  double ddf(double t) const { return value(derived(derived(c)), t); }
  Interval range_f(double a, double b) const { return ++intervals, range(c, a, b); }
  Interval range_df(double a, double b) const { return range(derived(c), a, b); }
  Interval range_ddf(double a, double b) const { return range(derived(derived(c)), a, b); }
};

Enclosed enclosed_with_roots(const std::vector<double>& roots) {
  std::vector<double> c{1.0};
  for (const double r : roots) {
    std::vector<double> next(c.size() + 1, 0.0);
    for (std::size_t i = 0; i < c.size(); ++i) {
      next[i + 1] += c[i];
      next[i] -= c[i] * r;
    }
    c = next;
  }
  return {c};
}

TEST(IsolatedRoots, FindsKnownRootsInFewIntervals) {
  Random random(4);
  for (int i = 0; i < 500; ++i) {
    std::vector<double> roots;
    for (int k = 0; k < 4; ++k) roots.push_back(random.uniform(-1.0, 1.0));
    std::sort(roots.begin(), roots.end());
    double gap = 1.0;
    for (int k = 1; k < 4; ++k) gap = std::min(gap, roots[k] - roots[k - 1]);
    if (gap < 0.1) continue;
    const Enclosed h = enclosed_with_roots(roots);
    std::vector<double> found;
    isolated_roots(h, -1.0, 1.0, found);
    ASSERT_EQ(found.size(), 4u);
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(found[k], roots[k], 1e-9);
    EXPECT_LT(h.intervals, 1000);
  }
}

TEST(IsolatedRoots, EndsAndBisectionPoints) {
  // Roots at both ends and at the first bisection, each of them once.
  std::vector<double> found;
  isolated_roots(enclosed_with_roots({-1.0, 0.0, 1.0}), -1.0, 1.0, found);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0], -1.0);
  EXPECT_NEAR(found[1], 0.0, 1e-16);
  EXPECT_EQ(found[2], 1.0);
}

TEST(IsolatedRoots, MultipleRootsCostLittle) {
  // A triple root off the bisection points, at an end, and nearly triple ones.
  for (const double r : {0.1234567, 0.0, 1.0, 0.5}) {
    for (const double near : {0.0, 1e-3, 1e-6, 1e-9}) {
      const Enclosed h = enclosed_with_roots({r, r + near, r - near, -3.0});
      std::vector<double> found;
      isolated_roots(h, 0.0, 1.0, found);
      EXPECT_LT(h.intervals, 1500) << r << " " << near;
      // Rounding may cross zero more often than the function does, but only there.
      for (const double t : found) EXPECT_NEAR(t, r, 2.0 * near + 1e-4);
      if (r > 0.0 && r < 1.0) {
        EXPECT_GE(found.size(), 1u);
      }
    }
  }
}

TEST(IsolatedRoots, GivesUpWhereTheFunctionIsZero) {
  const Enclosed zero{{0.0, 0.0, 0.0, 0.0}};
  std::vector<double> found;
  isolated_roots(zero, 0.0, 1.0, found);
  EXPECT_LT(zero.intervals, 100000);
}

}  // namespace
}  // namespace caustic::geometry
