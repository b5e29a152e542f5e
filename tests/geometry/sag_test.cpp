// Height fields: Zernike's polynomials, splines through samples, rays over many cells. What all
// surfaces promise is in surface_test.cpp.
#include "geometry/sag.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/grid_spline.h"
#include "tests/support/random.h"
#include "tests/support/reference.h"
#include "tests/support/thorough.h"

namespace caustic::geometry {
namespace {

using test::Random;

constexpr int kScannedRays = test::thorough(60, 10), kSamples = test::thorough(20000, 5000);

// Mean over the unit disc, exact for polynomials of degree 2n − 1: Gauss's nodes in r², equal steps
// of the angle.
template <class F>
double mean_over_disc(const F& f) {
  constexpr int kNodes = 24, kAngles = 48;
  double sum = 0.0;
  for (int k = 0; k < kNodes; ++k) {
    // Newton's method on Legendre's polynomial P_24.
    double x = std::cos(kPi * (k + 0.75) / (kNodes + 0.5)), slope = 1.0;
    for (int step = 0; step < 20; ++step) {
      double p = 1.0, before = 0.0;
      for (int n = 1; n <= kNodes; ++n) {
        const double next = ((2 * n - 1) * x * p - (n - 1) * before) / n;
        before = p;
        p = next;
      }
      slope = kNodes * (x * p - before) / (x * x - 1.0);
      x -= p / slope;
    }
    const double weight = 1.0 / ((1.0 - x * x) * slope * slope), r = std::sqrt(0.5 * (x + 1.0));
    for (int a = 0; a < kAngles; ++a) {
      const double angle = 2.0 * kPi * (a + 0.3) / kAngles;
      sum += weight / kAngles * f(r * std::cos(angle), r * std::sin(angle));
    }
  }
  return sum;
}

TEST(Zernike, IsOrthonormalOverTheDisc) {
  for (int i = 0; i <= 65; i += 1) {
    for (int j = i; j <= 65; j += 3) {
      const auto p = zernike({{i, 1.0}}, 1.0), q = zernike({{j, 1.0}}, 1.0);
      const double mean = mean_over_disc([&](double x, double y) { return p(x, y) * q(x, y); });
      EXPECT_NEAR(mean, i == j ? 1.0 : 0.0, 1e-11) << i << " " << j;
    }
  }
}

// OSA/ANSI Z80.28: index, sign and name of the first ones.
TEST(Zernike, IsNumberedAsOsaDoes) {
  const double x = 0.3, y = -0.5, r2 = x * x + y * y;
  const double expected[] = {1.0,
                             2.0 * y,
                             2.0 * x,
                             std::sqrt(6.0) * 2.0 * x * y,
                             std::sqrt(3.0) * (2.0 * r2 - 1.0),
                             std::sqrt(6.0) * (x * x - y * y),
                             std::sqrt(8.0) * (3.0 * x * x * y - y * y * y),
                             std::sqrt(8.0) * (3.0 * r2 - 2.0) * y,
                             std::sqrt(8.0) * (3.0 * r2 - 2.0) * x,
                             std::sqrt(8.0) * (x * x * x - 3.0 * x * y * y)};
  for (int j = 0; j < 10; ++j) {
    EXPECT_NEAR(zernike({{j, 0.7}}, 1.0)(x, y), 0.7 * expected[j], 1e-15) << j;
    EXPECT_NEAR(zernike({{j, 0.7}}, 2.5)(2.5 * x, 2.5 * y), 0.7 * expected[j], 1e-15) << j;
  }
  EXPECT_NEAR(zernike({{12, 1.0}}, 1.0)(1.0, 0.0), std::sqrt(5.0), 1e-14);
}

// Radial polynomials are 1 at the rim; of degree 20 the sum there cancels 8·10⁶ to one.
TEST(Zernike, RoundsAsItsHighestDegreeAllows) {
  EXPECT_NEAR(zernike({{220, 1.0}}, 1.0)(1.0, 0.0), std::sqrt(21.0), 1e-8);
  EXPECT_NEAR(zernike({{kMaxZernikeIndex, 1.0}}, 1.0)(0.6, 0.8),
              std::sqrt(42.0) * std::cos(20.0 * std::atan2(0.8, 0.6)), 1e-8);
  EXPECT_EQ(zernike({{kMaxZernikeIndex, 1.0}}, 1.0).degree(), 20);
}

// Against Jacobi's recurrence in 50 digits: what is lost is ε P_{n/2}(3) of each coefficient.
TEST(Zernike, NormalsAndCurvaturesOfHighDegree) {
  Random random(6);
  test::ShapeSpec spec{.name = "zernike_high",
                       .kind = test::ShapeSpec::Kind::zernike,
                       .radius = 1.3,
                       .zernike = {{4, 0.1}, {33, 1e-3}, {40, -1e-3}, {65, 5e-4}, {119, -1e-4}}};
  const auto surface = test::build(spec);
  for (int i = 0; i < 200; ++i) {
    const double r = 1.3 * std::sqrt(random.uniform()), angle = random.uniform(0.0, 2.0 * kPi);
    const Point x(r * std::cos(angle), r * std::sin(angle), random.uniform(-0.1, 0.1));
    const auto d = surface->derivatives(x);
    const auto reference = test::reference_shape(spec, x);
    EXPECT_NEAR(d.g / d.gradient.norm(), reference.distance, 1e-14);
    const Vec3 n = d.gradient.normalized();
    const Mat3 P = Mat3::Identity() - n * n.transpose();
    EXPECT_LT((n - reference.normal).norm(), 1e-12);
    EXPECT_LT((P * d.hessian * P / d.gradient.norm() - reference.curvature).norm(), 1e-11);
  }
}

TEST(SagPolynomial, KnowsWhichParabolasAreConvex) {
  const auto parabola = [](double xx, double xy, double yy, double x3) {
    XyPolynomial f;
    f.add(2, 0, xx);
    f.add(1, 1, xy);
    f.add(0, 2, yy);
    f.add(3, 0, x3);
    return make_sag(Point::Zero(), Mat3::Identity(), f);
  };
  EXPECT_TRUE(parabola(-1.0, 1.0, -1.0, 0.0)->convex(1));
  EXPECT_FALSE(parabola(-1.0, 1.0, -1.0, 0.0)->convex(-1));
  EXPECT_TRUE(parabola(1.0, 1.0, 1.0, 0.0)->convex(-1));
  EXPECT_FALSE(parabola(-1.0, 3.0, -1.0, 0.0)->convex(1));
  EXPECT_FALSE(parabola(-1.0, 0.0, -1.0, 0.1)->convex(1));
}

// ---- Splines
// -------------------------------------------------------------------------------------

template <class F>
GridSpline spline_of(int nx, int ny, const F& f) {
  std::vector<double> values;
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) values.push_back(f(i, j));
  }
  return GridSpline(nx, ny, values);
}

TEST(GridSpline, PassesThroughItsSamples) {
  Random random(1);
  for (const auto& [nx, ny] : {std::pair(6, 6), std::pair(7, 23), std::pair(64, 9)}) {
    std::vector<double> values(nx * ny);
    for (double& value : values) value = random.uniform(-1.0, 1.0);
    const GridSpline spline(nx, ny, values);
    double d[1][1];
    for (int k = 0; k < nx * ny; ++k) {
      spline.derivatives<0>(k % nx, k / nx, d);
      EXPECT_NEAR(d[0][0], values[k], 1e-13);
    }
  }
}

TEST(GridSpline, IsExactForQuinticsWithTheirDerivatives) {
  Random random(2);
  for (const int n : {6, 7, 8, 11, 30}) {
    // x^5 y^4 − 2 x^3 y^5 + x − y², of coordinates about the middle, of order one.
    const double half = 0.5 * (n - 1);
    const auto x = [&](double u) { return (u - half) / half; };
    const auto f = [&](double u, double v) {
      const double X = x(u), Y = x(v);
      return std::pow(X, 5) * std::pow(Y, 4) - 2.0 * std::pow(X, 3) * std::pow(Y, 5) + X - Y * Y;
    };
    const GridSpline spline = spline_of(n, n, f);
    for (int k = 0; k < 100; ++k) {
      const double u = random.uniform(0.0, n - 1.0), v = random.uniform(0.0, n - 1.0);
      const double X = x(u), Y = x(v);
      double d[4][4];
      spline.derivatives<3>(u, v, d);
      const double p = 1.0 / half;
      EXPECT_NEAR(d[0][0], f(u, v), 1e-13);
      EXPECT_NEAR(d[1][0],
                  p * (5 * std::pow(X, 4) * std::pow(Y, 4) - 6 * X * X * std::pow(Y, 5) + 1),
                  1e-12);
      EXPECT_NEAR(d[1][1],
                  p * p * (20 * std::pow(X, 4) * std::pow(Y, 3) - 30 * X * X * std::pow(Y, 4)),
                  1e-12);
      EXPECT_NEAR(d[3][0], p * p * p * (60 * X * X * std::pow(Y, 4) - 12 * std::pow(Y, 5)), 1e-11);
      EXPECT_NEAR(d[1][2], p * p * p * (60 * std::pow(X, 4) * Y * Y - 120 * X * X * std::pow(Y, 3)),
                  1e-11);
    }
  }
}

// Sixth order in the spacing, up to the edges.
TEST(GridSpline, ConvergesWithTheSixthPowerOfTheSpacing) {
  double error[2] = {};
  for (const int k : {0, 1}) {
    const int n = k == 0 ? 25 : 49;
    const double h = 2.0 / (n - 1);
    const auto f = [&](double u, double v) {
      return std::sin(3.0 * h * u + 1.0) * std::cos(2.0 * h * v);
    };
    const GridSpline spline = spline_of(n, n, f);
    Random random(3);
    for (int i = 0; i < 2000; ++i) {
      const double u = random.uniform() * (n - 1), v = random.uniform() * (n - 1);
      double d[1][1];
      spline.derivatives<0>(u, v, d);
      error[k] = std::max(error[k], std::abs(d[0][0] - f(u, v)));
    }
  }
  EXPECT_LT(error[0], 1e-5);
  EXPECT_GT(std::log2(error[0] / error[1]), 5.5);
}

TEST(GridSpline, IsSmoothEverywhereAndLevelFarOut) {
  Random random(4);
  const GridSpline spline =
      spline_of(9, 8, [](int u, int v) { return std::sin(0.6 * u) * std::cos(0.5 * v + 0.3); });
  for (int u = -GridSpline::kMargin - 1; u <= 8 + GridSpline::kMargin + 1; ++u) {
    const double v = random.uniform(-7.0, 14.0);
    double below[4][4], above[4][4];
    spline.derivatives<3>(u - 1e-13, v, below);
    spline.derivatives<3>(u + 1e-13, v, above);
    for (int a = 0; a <= 3; ++a) {
      for (int b = 0; a + b <= 3; ++b) EXPECT_NEAR(below[a][b], above[a][b], 1e-10) << u;
    }
  }
  double edge[2][2], far[2][2];
  spline.derivatives<1>(-1e9, 3.3, far);
  spline.derivatives<1>(-GridSpline::kMargin, 3.3, edge);
  EXPECT_EQ(far[0][0], edge[0][0]);
  EXPECT_NEAR(far[1][0], 0.0, 1e-15);
  EXPECT_EQ(far[0][1], edge[0][1]);
}

// ---- Rays over a grid
// ----------------------------------------------------------------------------

SurfacePtr surface_of(int n, const std::vector<double>& values) {
  return make_sag(Point::Zero(), Mat3::Identity(), HeightGrid{{-1, -1}, {1, 1}, n, n, values});
}

// One raised sample of a quarter million: rays just under and just over its top.
TEST(SagHeights, ASpikeIsNotMissed) {
  constexpr int n = 512;
  std::vector<double> values(n * n, 0.1);
  values[200 * n + 300] = 0.11;
  const auto surface = surface_of(n, values);
  const double h = 2.0 / (n - 1), x = -1.0 + 300 * h, y = -1.0 + 200 * h;
  for (const double angle : {0.0, 0.4, 0.5 * kPi, 2.0}) {
    const Vec3 along(std::cos(angle), std::sin(angle), 0.0);
    for (const double depth : {1e-3, 1e-6, 1e-9}) {
      for (const int under : {1, -1}) {
        const Ray ray{Point(x, y, 0.11 - under * depth) - 40.0 * along, along};
        RayParameters found;
        surface->crossings(ray, 0.0, 100.0, found);
        std::erase_if(found, [&](double t) { return (ray.at(t) - Point(x, y, 0.11)).norm() > h; });
        EXPECT_EQ(found.size(), under > 0 ? 2u : 0u) << angle << " " << depth;
      }
    }
  }
}

// Against a fine scan of the surface's own value: all sign changes, and nothing else.
TEST(SagHeights, FindsWhatAScanFinds) {
  constexpr int n = 40;
  Random random(5);
  std::vector<double> values(n * n);
  for (double& value : values) value = random.uniform(-0.05, 0.05);
  const auto surface = surface_of(n, values);
  int checked = 0;
  for (int i = 0; i < kScannedRays; ++i) {
    const Point from(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-0.2, 0.2));
    const Point to(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-0.04, 0.04));
    const Ray ray{from, to - from};
    for (const bool still : {false, true}) {
      const auto f = [&](double t) {
        Vec3 gradient;
        const double g = surface->value_gradient(ray.at(t), gradient);
        return still ? gradient.dot(ray.direction) : g;
      };
      RayParameters found;
      still ? surface->stationary(ray, -1.0, 3.0, found)
            : surface->crossings(ray, -1.0, 3.0, found);
      EXPECT_TRUE(std::is_sorted(found.begin(), found.end()));
      EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end());
      for (const double t : found) {  // beyond the rough edge the spline goes far up and down
        if (!exists_at(surface->own_bounds(), ray.at(t))) continue;
        EXPECT_NEAR(f(t), 0.0, 1e-12);
      }
      for (int k = 0; k < kSamples; ++k) {
        const double a = -1.0 + 4.0 * k / kSamples, b = a + 4.0 / kSamples;
        if ((f(a) > 0.0) == (f(b) > 0.0)) continue;
        const auto place = std::lower_bound(found.begin(), found.end(), a - 1e-12);
        EXPECT_TRUE(place != found.end() && *place <= b + 1e-12) << a;
        ++checked;
      }
    }
  }
  EXPECT_GT(checked, 10 * kScannedRays);
}

TEST(SagHeights, ARayInTheSurfaceIsNoWork) {
  const auto flat = surface_of(64, std::vector<double>(64 * 64, 0.37));
  RayParameters found;
  flat->crossings({{-2.0, 0.1, 0.37}, {1, 0.2, 0}}, 0.0, 4.0, found);
  flat->stationary({{-2.0, 0.1, 0.2}, {1, 0.2, 0}}, 0.0, 4.0, found);
  EXPECT_TRUE(found.empty());
  flat->crossings({{0.3, 0.1, 2.0}, {0.1, 0, -1}}, 0.0, 4.0, found);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0], 1.63, 1e-14);
}

}  // namespace
}  // namespace caustic::geometry
