// Interval arithmetic without rounding modes: every operation rounds to nearest and its ends are
// then moved outward by at least the error of that rounding, so an Interval holds the exact result.
//
// A function that is undefined on a part of its argument is enclosed where it is defined; where it
// is so nowhere, the result is empty. Nothing here tells a part from the whole: who concludes from
// the sign of a derivative that a function is monotone asks first whether it is defined (sqrt, log,
// real powers and division say where). ∞ − ∞ and 0·∞ come from overflow or from functions without
// bound; they give the whole line.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace caustic::geometry {

/// The real numbers x with lo <= x <= hi. The ends may be infinite; both are NaN when it is empty.
struct Interval {
  double lo, hi;

  Interval() = default;  ///< leaves the ends open, as for double
  constexpr Interval(double x) : lo(x), hi(x) {}
  constexpr Interval(double low, double high) : lo(low), hi(high) {}

  static constexpr Interval whole() {
    return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  }
  static constexpr Interval empty_set() {
    return {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN()};
  }

  constexpr bool empty() const { return !(lo <= hi); }
  constexpr bool contains(double x) const { return lo <= x && x <= hi; }
  constexpr bool contains(const Interval& x) const { return lo <= x.lo && x.hi <= hi; }
  constexpr bool contains_zero() const { return lo <= 0.0 && hi >= 0.0; }
  bool bounded() const { return std::isfinite(lo) && std::isfinite(hi); }
  constexpr double width() const { return hi - lo; }
  constexpr double middle() const { return 0.5 * lo + 0.5 * hi; }
  /// Largest and smallest absolute value.
  double magnitude() const { return std::max(std::abs(lo), std::abs(hi)); }
  double mignitude() const { return contains_zero() ? 0.0 : std::min(std::abs(lo), std::abs(hi)); }
};

namespace rounding {

// S. Rump, P. Zimmermann, S. Boldo, G. Melquiond, Computing predecessor and successor in rounding
// to nearest, BIT 49 (2009): with u = 2⁻⁵³, φ = u(1 + 2u) and η the least positive number, c ∓
// (φ|c| + η) rounded to nearest is at most the predecessor, at least the successor of c. Beyond an
// overflow they give NaN. A sum needs no η: what underflows there is exact.
constexpr double kPhi = 0x1p-53 * (1.0 + 0x1p-52);
constexpr double kEta = std::numeric_limits<double>::denorm_min();

inline double below(double c) { return c - (kPhi * std::abs(c) + kEta); }
inline double above(double c) { return c + (kPhi * std::abs(c) + kEta); }
inline double below_sum(double c) { return c - kPhi * std::abs(c); }
inline double above_sum(double c) { return c + kPhi * std::abs(c); }

/// The interval of these ends, computed from a and b. An end that is NaN says nothing.
inline Interval checked(double lo, double hi, const Interval& a, const Interval& b) {
  if (lo <= hi) [[likely]]
    return {lo, hi};
  return a.empty() || b.empty() ? Interval::empty_set() : Interval::whole();
}

}  // namespace rounding

inline Interval operator-(const Interval& a) { return {-a.hi, -a.lo}; }

inline Interval operator+(const Interval& a, const Interval& b) {
  return rounding::checked(rounding::below_sum(a.lo + b.lo), rounding::above_sum(a.hi + b.hi), a,
                           b);
}

inline Interval operator-(const Interval& a, const Interval& b) {
  return rounding::checked(rounding::below_sum(a.lo - b.hi), rounding::above_sum(a.hi - b.lo), a,
                           b);
}

inline Interval operator*(const Interval& a, const Interval& b) {
  if (a.lo >= 0.0 && b.lo >= 0.0) {  // and the product is not negative either, however small
    return rounding::checked(std::max(0.0, rounding::below(a.lo * b.lo)),
                             rounding::above(a.hi * b.hi), a, b);
  }
  const double p = a.lo * b.lo, q = a.lo * b.hi, r = a.hi * b.lo, s = a.hi * b.hi;
  // Comparisons drop a NaN, a sum keeps it.
  if (std::isnan(p + q + r + s)) [[unlikely]]
    return rounding::checked(p + q + r + s, 0.0, a, b);
  return rounding::checked(rounding::below(std::min(std::min(p, q), std::min(r, s))),
                           rounding::above(std::max(std::max(p, q), std::max(r, s))), a, b);
}

inline Interval operator*(double a, const Interval& b) {
  const double p = a * b.lo, q = a * b.hi;
  return a >= 0.0 ? rounding::checked(rounding::below(p), rounding::above(q), a, b)
                  : rounding::checked(rounding::below(q), rounding::above(p), a, b);
}
inline Interval operator*(const Interval& a, double b) { return b * a; }

/// Undefined where b is zero.
Interval operator/(const Interval& a, const Interval& b);

inline Interval& operator+=(Interval& a, const Interval& b) { return a = a + b; }
inline Interval& operator-=(Interval& a, const Interval& b) { return a = a - b; }
inline Interval& operator*=(Interval& a, const Interval& b) { return a = a * b; }

inline Interval abs(const Interval& a) {
  return a.empty() ? a : Interval(a.mignitude(), a.magnitude());
}

inline Interval sqr(const Interval& a) {
  const double least = a.mignitude(), most = a.magnitude();
  return rounding::checked(std::max(0.0, rounding::below(least * least)),
                           rounding::above(most * most), a, a);
}

/// a^n; undefined at zero for negative n.
Interval power(const Interval& a, int n);
/// a^p for a > 0, and at a = 0 for p > 0; undefined elsewhere.
Interval power(const Interval& a, double p);
/// Undefined where a < 0.
Interval sqrt(const Interval& a);
Interval exp(const Interval& a);
/// Undefined where a <= 0.
Interval log(const Interval& a);
Interval sin(const Interval& a);
Interval cos(const Interval& a);

/// What is in both.
inline Interval intersection(const Interval& a, const Interval& b) {
  if (a.empty() || b.empty() || a.hi < b.lo || b.hi < a.lo) return Interval::empty_set();
  return {std::max(a.lo, b.lo), std::min(a.hi, b.hi)};
}

/// Two enclosures of one thing; rounding alone parts them.
inline Interval meet(const Interval& a, const Interval& b) {
  const Interval both = intersection(a, b);
  return both.empty() ? b : both;
}
/// The least interval that holds both.
inline Interval hull(const Interval& a, const Interval& b) {
  if (a.empty()) return b;
  if (b.empty()) return a;
  return {std::min(a.lo, b.lo), std::max(a.hi, b.hi)};
}

}  // namespace caustic::geometry
