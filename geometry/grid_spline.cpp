#include "geometry/grid_spline.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace caustic::geometry {

namespace {

using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Coefficients of the quintic splines through the columns of `samples`: n + 4 rows from n. The
// spline is (1, 26, 66, 26, 1)/120 of five neighbouring coefficients at a sample, and the jump of
// its fifth derivative at a knot their sixth difference, (1, −6, 15, −20, 15, −6, 1). Elimination
// in the band, with pivots chosen in it.
Rows interpolated(const Rows& samples) {
  constexpr int kBelow = 6, kAbove = 12;
  constexpr double kAtSample[] = {1.0 / 120, 26.0 / 120, 66.0 / 120, 26.0 / 120, 1.0 / 120};
  constexpr double kJump[] = {1, -6, 15, -20, 15, -6, 1};
  const int n = static_cast<int>(samples.rows()), size = n + 4;
  // A(i, j) stands in band(i, j − i + kBelow).
  Rows band = Rows::Zero(size, kBelow + kAbove + 1);
  const auto A = [&](int i, int j) -> double& { return band(i, j - i + kBelow); };
  for (int k = 0; k < 7; ++k) {
    A(0, k) = A(1, k + 1) = A(size - 2, size - 8 + k) = A(size - 1, size - 7 + k) = kJump[k];
  }
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < 5; ++k) A(i + 2, i + k) = kAtSample[k];
  }
  Rows c = Rows::Zero(size, samples.cols());
  c.middleRows(2, n) = samples;

  for (int k = 0; k < size; ++k) {
    const int bottom = std::min(size - 1, k + kBelow), right = std::min(size - 1, k + kAbove);
    int pivot = k;
    for (int i = k + 1; i <= bottom; ++i) {
      if (std::abs(A(i, k)) > std::abs(A(pivot, k))) pivot = i;
    }
    if (pivot != k) {
      for (int j = k; j <= right; ++j) std::swap(A(k, j), A(pivot, j));
      c.row(k).swap(c.row(pivot));
    }
    for (int i = k + 1; i <= bottom; ++i) {
      const double factor = A(i, k) / A(k, k);
      if (factor == 0.0) continue;
      for (int j = k; j <= right; ++j) A(i, j) -= factor * A(k, j);
      c.row(i) -= factor * c.row(k);
    }
  }
  for (int k = size - 1; k >= 0; --k) {
    for (int j = k + 1; j <= std::min(size - 1, k + kAbove); ++j) c.row(k) -= A(k, j) * c.row(j);
    c.row(k) /= A(k, k);
  }
  return c;
}

// The six uniform quintic B-splines that are not zero on a cell, by the recurrence over degrees
//   N_k^p = ((t + p − k) N_{k−1}^{p−1} + (k + 1 − t) N_k^{p−1})/p,   (N_k^p)' = N_{k−1}^{p−1} −
//   N_k^{p−1}.
// b[d][k] is the d-th derivative of the k-th.
template <int kOrder>
void basis(double t, double (&b)[kOrder + 1][6]) {
  constexpr double kInverse[] = {1.0, 1.0, 1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0};
  double N[6] = {1.0};
  for (int p = 0; p <= 5; ++p) {
    for (int k = p; p > 0 && k >= 0; --k) {
      const double left = k > 0 ? (t + p - k) * N[k - 1] : 0.0;
      const double right = k < p ? (k + 1 - t) * N[k] : 0.0;
      N[k] = kInverse[p] * (left + right);
    }
    const int d = 5 - p;
    if (d > kOrder) continue;
    std::copy_n(N, 6, b[d]);
    for (int i = 0; i < d; ++i) {
      for (int k = 5; k >= 0; --k) b[d][k] = (k > 0 ? b[d][k - 1] : 0.0) - b[d][k];
    }
  }
}

using Quintic = std::array<double, 6>;

// The same as polynomials of s, t = t0 + t1 s.
std::array<Quintic, 6> basis_along(double t0, double t1) {
  std::array<Quintic, 6> N{};
  N[0][0] = 1.0;
  for (int p = 1; p <= 5; ++p) {
    for (int k = p; k >= 0; --k) {
      Quintic sum{};
      const auto add = [&](const Quintic& q, double c0, double c1) {
        for (int i = 0; i < p; ++i) {
          sum[i] += c0 * q[i] / p;
          sum[i + 1] += c1 * q[i] / p;
        }
      };
      if (k > 0) add(N[k - 1], t0 + p - k, t1);
      if (k < p) add(N[k], k + 1 - t0, -t1);
      N[k] = sum;
    }
  }
  return N;
}

}  // namespace

GridSpline::GridSpline(int nx, int ny, const std::vector<double>& values)
    : nx_(nx), ny_(ny), stride_(nx + 4 + 2 * kMargin) {
  const Rows samples = Eigen::Map<const Rows>(values.data(), ny, nx);
  const Rows along_v = interpolated(samples);                          // ny + 4 rows
  const Rows c = interpolated(Rows(along_v.transpose())).transpose();  // … and nx + 4 columns
  const int rows = ny + 4 + 2 * kMargin;
  c_.resize(static_cast<std::size_t>(stride_) * rows);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < stride_; ++i) {
      c_[j * stride_ + i] =
          c(std::clamp(j - kMargin, 0, ny + 3), std::clamp(i - kMargin, 0, nx + 3));
    }
  }
}

template <int kOrder>
void GridSpline::derivatives(double u, double v, double (&d)[kOrder + 1][kOrder + 1]) const {
  // The outermost cells are level, so beyond them is as at their edge.
  const double s = std::clamp(u + kMargin, 0.0, static_cast<double>(cells_u()));
  const double t = std::clamp(v + kMargin, 0.0, static_cast<double>(cells_v()));
  const int i = std::min(static_cast<int>(s), cells_u() - 1);
  const int j = std::min(static_cast<int>(t), cells_v() - 1);
  double b_u[kOrder + 1][6], b_v[kOrder + 1][6];
  basis<kOrder>(s - i, b_u);
  basis<kOrder>(t - j, b_v);
  // Rows first: their six coefficients lie side by side.
  double rows[kOrder + 1][6] = {};
  const double* c = block(i, j);
  for (int row = 0; row < 6; ++row, c += stride_) {
    for (int b = 0; b <= kOrder; ++b) {
      for (int k = 0; k < 6; ++k) rows[b][k] += b_v[b][row] * c[k];
    }
  }
  for (int a = 0; a <= kOrder; ++a) {
    for (int b = 0; a + b <= kOrder; ++b) {
      d[a][b] = 0.0;
      for (int k = 0; k < 6; ++k) d[a][b] += b_u[a][k] * rows[b][k];
    }
  }
}

template void GridSpline::derivatives<0>(double, double, double (&)[1][1]) const;
template void GridSpline::derivatives<1>(double, double, double (&)[2][2]) const;
template void GridSpline::derivatives<3>(double, double, double (&)[4][4]) const;

LongPolynomial GridSpline::along(int cell_u, int cell_v, const Vec2& at,
                                 const Vec2& direction) const {
  // Outermost cells are level in that direction: any place of them will do.
  const auto local = [](int cell, int cells, double x, double dx) {
    const bool outermost = cell == 0 || cell == cells - 1;
    return outermost ? basis_along(0.5, 0.0) : basis_along(x + kMargin - cell, dx);
  };
  const auto b_u = local(cell_u, cells_u(), at.x(), direction.x());
  const auto b_v = local(cell_v, cells_v(), at.y(), direction.y());
  LongPolynomial f;
  f.degree = 10;
  const double* c = block(cell_u, cell_v);
  for (int row = 0; row < 6; ++row, c += stride_) {
    Quintic along_u{};
    for (int k = 0; k < 6; ++k) {
      for (int i = 0; i < 6; ++i) along_u[i] += c[k] * b_u[k][i];
    }
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) f.c[i + j] += along_u[i] * b_v[row][j];
    }
  }
  return f;
}

HeightRanges GridSpline::hull(int cell_u, int cell_v) const {
  const double* block_begin = block(cell_u, cell_v);
  HeightRanges hull;
  // Differences of order (a, b) over the block: its derivative of that order is a mean of them.
  for (int order = 0; order < 6; ++order) {
    const auto [a, b] = kOrdersOfRanges[order];
    const std::ptrdiff_t du = a > 0 ? 1 : 0, dv = b > 0 ? stride_ : 0;
    double lo = kInfinity, hi = -kInfinity;
    for (int row = 0; row < 6 - b; ++row) {
      const double* c = block_begin + row * stride_;
      for (int k = 0; k < 6 - a; ++k, ++c) {
        double d = *c;
        if (a + b == 1) d = c[du + dv] - c[0];
        if (a == 2) d = c[2] - 2.0 * c[1] + c[0];
        if (b == 2) d = c[2 * stride_] - 2.0 * c[stride_] + c[0];
        if (a == 1 && b == 1) d = (c[1 + stride_] - c[stride_]) - (c[1] - c[0]);
        lo = std::min(lo, d);
        hi = std::max(hi, d);
      }
    }
    hull[order] = Interval(lo, hi);
  }
  return hull;
}

HeightRanges GridSpline::ranges(int cell_u, int cell_v, const Interval& u,
                                const Interval& v) const {
  // Middle and half width of the part of the cell, in the cell's own coordinate.
  struct Part {
    double middle, half;
  };
  const auto part = [](int cell, const Interval& x) {
    const double lo = std::clamp(x.lo + kMargin - cell, 0.0, 1.0);
    const double hi = std::clamp(x.hi + kMargin - cell, 0.0, 1.0);
    return Part{0.5 * (lo + hi), 0.5 * (hi - lo) + kEpsilon * (std::abs(x.lo) + std::abs(x.hi))};
  };
  const Part p = part(cell_u, u), q = part(cell_v, v);
  double b_u[6][6], b_v[6][6], t[6][6] = {}, size = 0.0;
  basis<5>(p.middle, b_u);
  basis<5>(q.middle, b_v);
  const double* c = block(cell_u, cell_v);
  for (int row = 0; row < 6; ++row, c += stride_) {
    for (int i = 0; i < 6; ++i) {
      double sum = 0.0;
      for (int k = 0; k < 6; ++k) sum += b_u[i][k] * c[k];
      for (int j = 0; j < 6; ++j) t[i][j] += b_v[j][row] * sum;
    }
    for (int k = 0; k < 6; ++k) size = std::max(size, std::abs(c[k]));
  }
  constexpr double kFactorial[] = {1, 1, 2, 6, 24, 120};
  HeightRanges r = taylor_ranges(
      5, 5, [&](int i, int j) { return t[i][j] / (kFactorial[i] * kFactorial[j]); }, p.half,
      q.half);
  // Rows of the basis' derivatives have sums of absolute values up to 2⁵.
  for (Interval& range : r) range += 1024.0 * kEpsilon * size * Interval(-1.0, 1.0);
  return r;
}

}  // namespace caustic::geometry
