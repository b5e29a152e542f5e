// Places of curves in space whose equation is known.
#include "solver/hermite_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace caustic::solver {
namespace {

using geometry::Point;
using geometry::Vec3;

// A helix of radius and pitch one; curvature and torsion are a half.
CurvePlace helix(double s) {
  const double w = s / std::sqrt(2.0);
  return {Point(std::cos(w), std::sin(w), w),
          Vec3(-std::sin(w), std::cos(w), 1.0) / std::sqrt(2.0)};
}

// The helix at the place `ahead` of its beginning along the tangent there.
Point helix_ahead(double ahead) {
  const CurvePlace start = helix(0);
  double s = ahead;
  for (int i = 0; i < 50; ++i) {
    const CurvePlace at = helix(s);
    s -= (start.t.dot(at.x - start.x) - ahead) / start.t.dot(at.t);
  }
  return helix(s).x;
}

double error(const std::vector<double>& places, double ahead) {
  std::vector<CurvePlace> known;
  for (const double s : places) known.push_back(helix(s));
  const auto x = hermite_curve(known, ahead);
  EXPECT_TRUE(x);
  return (*x - helix_ahead(ahead)).norm();
}

// Halved distances leave 2⁻²ᵐ of the error.
TEST(HermiteCurve, MissesBySoMuchAsItsDegreeSays) {
  for (int m = 1; m <= 4; ++m) {
    const auto places = [&](double h) {
      std::vector<double> all = {0.0, 3.0 * h, -h, -2.0 * h};
      all.resize(m);
      return all;
    };
    const double h = m < 4 ? 0.1 : 0.2;
    EXPECT_NEAR(std::log2(error(places(h), h) / error(places(0.5 * h), 0.5 * h)), 2.0 * m, 0.3)
        << m;
  }
}

TEST(HermiteCurve, MissesLessThanItsBound) {
  const double R = 2.0;  // radius of curvature
  for (const double h : {0.02, 0.05, 0.1}) {
    for (const double H : {0.2, 0.5}) {
      EXPECT_LT(error({0.0, H, -h, -2.0 * h}, h),
                10.0 * std::pow(h, 6) * H * H / std::pow(R, 7) + 1e-15);
    }
  }
}

TEST(HermiteCurve, IsThereAtItsPlaces) {
  const CurvePlace a = helix(0), b = helix(0.3);
  const std::vector<CurvePlace> known = {a, b, helix(-0.1)};
  EXPECT_LT((*hermite_curve(known, 0.0) - a.x).norm(), 1e-15);
  EXPECT_LT((*hermite_curve(known, a.t.dot(b.x - a.x)) - b.x).norm(), 1e-15);
}

TEST(HermiteCurve, HasNothingWhereTheCurveTurnsBack) {
  const std::vector<CurvePlace> known = {{Point(0, 0, 0), Vec3(1, 0, 0)},
                                         {Point(1, 1, 0), Vec3(-1, 0, 0)}};
  EXPECT_FALSE(hermite_curve(known, 0.5));
}

}  // namespace
}  // namespace caustic::solver
