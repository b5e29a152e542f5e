#include "geometry/grid_spline.h"

#include <Eigen/Core>
#include <algorithm>
#include <cassert>
#include <cmath>

namespace caustic::geometry {

namespace {

constexpr double kFactorial[] = {1, 1, 2, 6};

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

// The six uniform quintic B-splines that are not zero on a cell, by powers of t in [0, 1].
constexpr auto kBasis = [] {
  std::array<std::array<double, 6>, 6> basis{{{1, 26, 66, 26, 1, 0},      // 1
                                              {-5, -50, 0, 50, 5, 0},     // t
                                              {10, 20, -60, 20, 10, 0},   // t²
                                              {-10, 20, 0, -20, 10, 0},   // t³
                                              {5, -20, 30, -20, 5, 0},    // t⁴
                                              {-1, 5, -10, 10, -5, 1}}};  // t⁵
  for (auto& row : basis) {
    for (double& coefficient : row) coefficient /= 120.0;
  }
  return basis;
}();

// b[d][k] is the d-th derivative of the k-th, over d!: Horner's scheme for all six at once.
template <int kOrder>
void basis_taylor(double t, double (&b)[kOrder + 1][6]) {
  for (auto& row : b) std::fill(std::begin(row), std::end(row), 0.0);
  for (int i = 5; i >= 0; --i) {
    for (int d = kOrder; d > 0; --d) {
      for (int k = 0; k < 6; ++k) b[d][k] = b[d][k] * t + b[d - 1][k];
    }
    for (int k = 0; k < 6; ++k) b[0][k] = b[0][k] * t + kBasis[i][k];
  }
}

}  // namespace

GridSpline::GridSpline(int nx, int ny, const std::vector<double>& values)
    : nx_(nx), ny_(ny), stride_(nx + 4 + 2 * kMargin) {
  assert(nx >= kMinSamples && ny >= kMinSamples);
  assert(values.size() == static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny));
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
  basis_taylor<kOrder>(s - i, b_u);
  basis_taylor<kOrder>(t - j, b_v);
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
      d[a][b] *= kFactorial[a] * kFactorial[b];
    }
  }
}

template void GridSpline::derivatives<0>(double, double, double (&)[1][1]) const;
template void GridSpline::derivatives<1>(double, double, double (&)[2][2]) const;
template void GridSpline::derivatives<3>(double, double, double (&)[4][4]) const;

LongPolynomial GridSpline::along(int cell_u, int cell_v, const Vec2& at,
                                 const Vec2& direction) const {
  // b[i][k] is the coefficient of t^i in the k-th. Outermost cells are level in that direction: any
  // place of them will do.
  const auto local = [](int cell, int cells, double x, double dx, double(&b)[6][6]) {
    const bool outermost = cell == 0 || cell == cells - 1;
    basis_taylor<5>(outermost ? 0.5 : x + kMargin - cell, b);
    double power = 1.0;
    for (auto& row : b) {
      for (double& coefficient : row) coefficient *= power;
      power *= outermost ? 0.0 : dx;
    }
  };
  double b_u[6][6], b_v[6][6];
  local(cell_u, cells_u(), at.x(), direction.x(), b_u);
  local(cell_v, cells_v(), at.y(), direction.y(), b_v);
  LongPolynomial f;
  f.degree = 10;
  const double* c = block(cell_u, cell_v);
  for (int row = 0; row < 6; ++row, c += stride_) {
    for (int i = 0; i < 6; ++i) {
      double along_u = 0.0;
      for (int k = 0; k < 6; ++k) along_u += c[k] * b_u[i][k];
      for (int j = 0; j < 6; ++j) f.c[i + j] += along_u * b_v[j][row];
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

template <std::size_t kCount>
std::array<Interval, kCount> GridSpline::ranges_of(const int (&orders)[kCount][2], int cell_u,
                                                   int cell_v, const Interval& u,
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
  basis_taylor<5>(p.middle, b_u);
  basis_taylor<5>(q.middle, b_v);
  const double* c = block(cell_u, cell_v);
  for (int row = 0; row < 6; ++row, c += stride_) {
    for (int i = 0; i < 6; ++i) {
      double sum = 0.0;
      for (int k = 0; k < 6; ++k) sum += b_u[i][k] * c[k];
      for (int j = 0; j < 6; ++j) t[i][j] += b_v[j][row] * sum;
    }
    for (int k = 0; k < 6; ++k) size = std::max(size, std::abs(c[k]));
  }
  auto r = taylor_ranges(
      orders, 5, 5, [&](int i, int j) { return t[i][j]; }, p.half, q.half);
  // Absolute values of a row of the basis, over factorials, have sums of at most one.
  for (Interval& range : r) range += 1024.0 * kEpsilon * size * Interval(-1.0, 1.0);
  return r;
}

HeightRanges GridSpline::ranges(int cell_u, int cell_v, const Interval& u,
                                const Interval& v) const {
  return ranges_of(kOrdersOfRanges, cell_u, cell_v, u, v);
}
ThirdRanges GridSpline::third_ranges(int cell_u, int cell_v, const Interval& u,
                                     const Interval& v) const {
  return ranges_of(kOrdersOfThirds, cell_u, cell_v, u, v);
}

}  // namespace caustic::geometry
