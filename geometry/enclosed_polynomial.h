// Polynomials of any useful degree along a ray, with enclosures: isolated_roots finds all their
// roots.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "geometry/root_finding.h"

namespace caustic::geometry {

/// c[0] + c[1] t + … + c[degree] t^degree, in place.
struct LongPolynomial {
  static constexpr int kMaxDegree = 40;
  std::array<double, kMaxDegree + 1> c{};
  int degree = 0;

  double operator()(double t) const;
  LongPolynomial derivative() const;
  /// q with q(w) = p(t + w).
  LongPolynomial about(double t) const;
};
/// The degrees of the factors must not exceed kMaxDegree together.
LongPolynomial operator*(const LongPolynomial& a, const LongPolynomial& b);

/// A polynomial as isolated_roots wants it. Over [m − h, m + h] the Taylor series about m bounds
/// it: odd powers of w = (t − m)/h lie in [−1, 1], even ones in [0, 1]. The bounds are widened by
/// the rounding of the series, n ε Σ |c_k| (|m| + h)^k times a small number.
class EnclosedPolynomial {
 public:
  explicit EnclosedPolynomial(const LongPolynomial& p) : p_(p) {}

  double f(double t) const { return derivatives(t)[0]; }
  double df(double t) const { return derivatives(t)[1]; }
  double ddf(double t) const { return derivatives(t)[2]; }
  Interval range_f(double a, double b) const { return range(0, a, b); }
  Interval range_df(double a, double b) const { return range(1, a, b); }
  Interval range_ddf(double a, double b) const { return range(2, a, b); }

 private:
  std::array<double, 3> derivatives(double t) const;
  Interval range(int order, double a, double b) const;
  void expand(double a, double b) const;

  LongPolynomial p_;
  // The last expansion: isolated_roots asks for three ranges of one interval.
  mutable LongPolynomial about_;
  mutable double a_ = 0.0, b_ = -1.0;
  mutable std::array<double, 3> slack_{};
};

/// The same, its values taken from a formula that rounds less than the expanded polynomial; from
/// which they differ by at most `rounding` beyond what the polynomial knows of.
template <class Value>
struct PolynomialWithValues : EnclosedPolynomial {
  PolynomialWithValues(const LongPolynomial& p, Value formula, double more_rounding = 0.0)
      : EnclosedPolynomial(p), value(std::move(formula)), rounding(more_rounding) {}
  double f(double t) const { return value(t); }
  Interval range_f(double a, double b) const {
    const Interval r = EnclosedPolynomial::range_f(a, b);
    return {r.lo - rounding, r.hi + rounding};
  }
  Value value;
  double rounding;
};

/// Appends the roots of h(τ − shift) in [t0, t1], increasing.
template <EnclosedFunction H>
void append_roots(const H& h, double shift, double t0, double t1, std::vector<double>& out) {
  const std::size_t first = out.size();
  isolated_roots(h, t0 - shift, t1 - shift, out);
  for (std::size_t i = first; i < out.size(); ++i) out[i] += shift;
}

}  // namespace caustic::geometry
