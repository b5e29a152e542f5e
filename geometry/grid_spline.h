// A surface of quintic B-splines through heights on a grid (S22).
#pragma once

#include <array>
#include <vector>

#include "geometry/enclosed_polynomial.h"
#include "geometry/linear.h"
#include "geometry/taylor_ranges.h"

namespace caustic::geometry {

/// The tensor product of quintic splines through nx × ny samples at whole (u, v) from (0, 0) to
/// (nx − 1, ny − 1): four times continuously differentiable, and exact for polynomials of degree 5
/// in u and in v, since the two knots next to each end are none (the fifth derivative does not jump
/// there). Beyond its last coefficient on each side all are equal to that one: the spline levels
/// off within kMargin cells, so it is defined and bounded everywhere.
class GridSpline {
 public:
  static constexpr int kMinSamples = 6;
  static constexpr int kMargin = 5;

  /// values[j·nx + i] at (i, j); nx, ny ≥ kMinSamples.
  GridSpline(int nx, int ny, const std::vector<double>& values);

  /// Cells along u and v, the margin's among them. Cell i lies between u = i − kMargin and one
  /// more; the first and the last extend to infinity.
  int cells_u() const { return nx_ - 1 + 2 * kMargin; }
  int cells_v() const { return ny_ - 1 + 2 * kMargin; }

  /// d[a][b] = ∂^(a+b)/∂u^a∂v^b for a + b ≤ kOrder, kOrder one of 0, 1, 3.
  template <int kOrder>
  void derivatives(double u, double v, double (&d)[kOrder + 1][kOrder + 1]) const;

  /// The spline in one cell along (u, v) + t (du, dv): degree 10.
  LongPolynomial along(int cell_u, int cell_v, const Vec2& at, const Vec2& direction) const;

  /// Over one cell: hulls of the coefficients and of their differences.
  HeightRanges hull(int cell_u, int cell_v) const;
  /// Over the part of one cell with u and v in these intervals, ever tighter as they shrink.
  HeightRanges ranges(int cell_u, int cell_v, const Interval& u, const Interval& v) const;
  ThirdRanges third_ranges(int cell_u, int cell_v, const Interval& u, const Interval& v) const;

 private:
  template <std::size_t kCount>
  std::array<Interval, kCount> ranges_of(const int (&orders)[kCount][2], int cell_u, int cell_v,
                                         const Interval& u, const Interval& v) const;
  const double* block(int cell_u, int cell_v) const { return &c_[cell_v * stride_ + cell_u]; }

  int nx_, ny_, stride_;
  std::vector<double> c_;  ///< rows of v, the margins included
};

}  // namespace caustic::geometry
