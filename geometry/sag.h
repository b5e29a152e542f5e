// Height fields over a plane: z = f(x, y) in axes of their own, g = z − f (S21).
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "geometry/enclosed_polynomial.h"
#include "geometry/surface.h"
#include "geometry/taylor_ranges.h"

namespace caustic::geometry {

/// f with its derivatives to third order; d[k] holds ∂^k f/∂x^(k−l)∂y^l, l = 0 … k.
struct HeightJet {
  double f;
  std::array<double, 2> d1;
  std::array<double, 3> d2;
  std::array<double, 4> d3;
};

/// What all height fields share. The inside, g < 0, is the −z side.
class SagSurface : public Surface {
 public:
  double value(const Point& x) const final;
  double value_gradient(const Point& x, Vec3& gradient) const final;
  SurfaceDerivatives derivatives(const Point& x) const final;
  Vec3 third_derivative(const Point& x, const Vec3& u, const Vec3& v) const final;
  ThirdDerivatives third_derivatives(const Point& x, const Vec3& u, const Vec3& v) const final;
  SurfaceEnclosure enclose(const IntervalVec3& x) const final;
  IntervalSym333 enclose_third(const IntervalVec3& x) const final;

 protected:
  SagSurface(const Point& origin, const Mat3& axes) : o_(origin), axes_(axes) {}

  Vec3 contracted(const HeightJet& h, const Vec3& u, const Vec3& v) const;
  virtual double height(double x, double y) const = 0;
  virtual double height_slope(double x, double y, Vec2& slope) const = 0;
  virtual HeightJet height_jet(double x, double y) const = 0;
  virtual HeightRanges height_ranges(const Interval& x, const Interval& y) const = 0;
  virtual ThirdRanges height_third_ranges(const Interval& x, const Interval& y) const = 0;

  Vec3 local(const Point& x) const { return axes_.transpose() * (x - o_); }

  Point o_;
  Mat3 axes_;  ///< columns x, y, z
};

/// Σ c(i, j) (x/unit)^i (y/unit)^j over i + j ≤ degree.
class XyPolynomial {
 public:
  static constexpr int kMaxDegree = 20;

  explicit XyPolynomial(double unit = 1.0) : unit_(unit) {}
  /// Adds c to the coefficient of (x/unit)^i (y/unit)^j.
  void add(int i, int j, double c);

  int degree() const { return degree_; }
  double coefficient(int i, int j) const;
  double operator()(double x, double y) const;
  double slope(double x, double y, Vec2& slope) const;
  HeightJet jet(double x, double y) const;
  HeightRanges ranges(const Interval& x, const Interval& y) const;
  ThirdRanges third_ranges(const Interval& x, const Interval& y) const;
  /// Along x + t dx, y + t dy.
  LongPolynomial along(const Vec2& at, const Vec2& direction) const;

 private:
  template <int kOrder>
  void derivatives(double x, double y, double (&d)[kOrder + 1][kOrder + 1]) const;
  template <std::size_t kCount>
  std::array<Interval, kCount> ranges_of(const int (&orders)[kCount][2], const Interval& x,
                                         const Interval& y) const;
  /// By rows of i, each j = 0 … degree − i.
  int index(int i, int j) const { return i * (degree_ + 1) - i * (i - 1) / 2 + j; }

  double unit_;
  int degree_ = 0;
  std::vector<double> c_ = {0.0};
};

/// Σ coefficients[j] Z_j over the disc of radius `norm_radius` (S21), Z_j Zernike's polynomials in
/// the order of OSA/ANSI, of norm √π there. j ≤ kMaxZernikeIndex, which is degree 20.
constexpr int kMaxZernikeIndex = 230;
XyPolynomial zernike(const std::vector<std::pair<int, double>>& coefficients, double norm_radius);

/// z = height(x, y), the columns of `axes` being the directions x, y, z; unbounded.
SurfacePtr make_sag(const Point& origin, const Mat3& axes, const XyPolynomial& height);

/// Heights at nx × ny places from min to max, values[j·nx + i] at the i-th x and the j-th y.
struct HeightGrid {
  Vec2 min = Vec2::Zero(), max = Vec2::Zero();
  int nx = 0, ny = 0;
  std::vector<double> values;
};
/// The surface through them (S22), which ends with the grid; at least kMinSamples each way.
constexpr int kMinSamples = 6;
SurfacePtr make_sag(const Point& origin, const Mat3& axes, const HeightGrid& grid);

}  // namespace caustic::geometry
