// What a polynomial of two variables and its derivatives to second order take on about zero.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/interval.h"
#include "geometry/linear.h"

namespace caustic::geometry {

/// Ranges of f and of its derivatives x, y, xx, xy, yy over a box.
using HeightRanges = std::array<Interval, 6>;
constexpr int kOrdersOfRanges[6][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};

/// Ranges of the derivatives xxx, xxy, xyy, yyy.
using ThirdRanges = std::array<Interval, 4>;
constexpr int kOrdersOfThirds[4][2] = {{3, 0}, {2, 1}, {1, 2}, {0, 3}};

/// Of derivatives of Σ c(i, j) x^i y^j, i ≤ degree_x, j ≤ degree_y, over |x| ≤ hx, |y| ≤ hy, term
/// by term: those even in both variables keep their sign. Rounding is allowed for, that of the
/// coefficients is not.
template <class Coefficient, std::size_t kCount>
std::array<Interval, kCount> taylor_ranges(const int (&orders)[kCount][2], int degree_x,
                                           int degree_y, const Coefficient& c, double hx,
                                           double hy) {
  std::array<Interval, kCount> ranges;
  for (std::size_t order = 0; order < kCount; ++order) {
    const int a = orders[order][0], b = orders[order][1];
    double lo = 0.0, hi = 0.0, x_power = 1.0;
    for (int i = a; i <= degree_x; ++i, x_power *= hx) {
      double y_power = x_power;
      for (int j = b; j <= degree_y; ++j, y_power *= hy) {
        double term = c(i, j) * y_power;
        for (int k = 0; k < a; ++k) term *= i - k;
        for (int k = 0; k < b; ++k) term *= j - k;
        const bool fixed = i == a && j == b, even = (i - a) % 2 == 0 && (j - b) % 2 == 0;
        const double size = std::abs(term);
        lo += fixed ? term : even ? std::min(0.0, term) : -size;
        hi += fixed ? term : even ? std::max(0.0, term) : size;
      }
    }
    const double slack = kEpsilon * (degree_x + 1) * (degree_y + 1) * (std::abs(lo) + std::abs(hi));
    ranges[order] = Interval(lo - slack, hi + slack);
    if (ranges[order].empty()) ranges[order] = Interval::whole();  // overflow says nothing
  }
  return ranges;
}

}  // namespace caustic::geometry
