#include "geometry/interval.h"

#include "geometry/linear.h"

namespace caustic::geometry {

namespace {

using rounding::above;
using rounding::below;
using rounding::checked;

// The C library's functions are good to less than one unit in the last place; two steps outward
// hold that at a power of two as well.
double library_below(double y) { return below(below(y)); }
double library_above(double y) { return above(above(y)); }

// x^n for x >= 0, n >= 1, by squaring, each product moved by `outward`.
template <class Outward>
double product_power(double x, unsigned n, const Outward& outward) {
  double result = 1.0;
  for (bool first = true;; x = outward(x * x)) {
    if (n & 1U) {
      result = first ? x : outward(result * x);
      first = false;
    }
    if ((n >>= 1U) == 0) return result;
  }
}

// a^n for n >= 1 and a >= 0.
Interval power_of_positive(const Interval& a, unsigned n) {
  if (n == 1) return a;
  const double lo = product_power(a.lo, n, [](double y) { return std::max(0.0, below(y)); });
  return checked(lo, product_power(a.hi, n, above), a, a);
}

// Range of cos(π·turn) for first <= turn <= last: its values at the ends, and ±1 at the integers.
Interval wave(double first, double last, double at_lo, double at_hi) {
  double lo = library_below(std::min(at_lo, at_hi)), hi = library_above(std::max(at_lo, at_hi));
  const double peak = std::ceil(first);
  const bool even = std::fmod(peak, 2.0) == 0.0;
  if (peak <= last) (even ? hi : lo) = even ? 1.0 : -1.0;
  if (peak + 1.0 <= last) (even ? lo : hi) = even ? -1.0 : 1.0;
  return {std::max(lo, -1.0), std::min(hi, 1.0)};
}

// Beyond, the phase is not worth knowing.
constexpr double kLargestPhase = 0x1p40;

}  // namespace

Interval operator/(const Interval& a, const Interval& b) {
  if (a.empty() || b.empty() || (b.lo == 0.0 && b.hi == 0.0)) return Interval::empty_set();
  if (b.contains_zero()) {
    if (b.lo < 0.0 && b.hi > 0.0) return Interval::whole();
    // One end of b is zero: the quotients go from that by the other end to infinity.
    const double end = b.lo == 0.0 ? b.hi : b.lo;
    if (a.lo >= 0.0 || a.hi <= 0.0) {
      const double nearest = below(a.mignitude() / std::abs(end));
      const Interval size{nearest > 0.0 ? nearest : 0.0, kInfinity};
      return (a.lo >= 0.0) == (end > 0.0) ? size : -size;
    }
    return Interval::whole();
  }
  if (a.lo >= 0.0 && b.lo > 0.0) {
    return checked(std::max(0.0, below(a.lo / b.hi)), above(a.hi / b.lo), a, b);
  }
  const double p = a.lo / b.lo, q = a.lo / b.hi, r = a.hi / b.lo, s = a.hi / b.hi;
  if (std::isnan(p + q + r + s)) return Interval::whole();
  return checked(below(std::min(std::min(p, q), std::min(r, s))),
                 above(std::max(std::max(p, q), std::max(r, s))), a, b);
}

Interval power(const Interval& a, int n) {
  if (a.empty()) return a;
  if (n == 0) return 1.0;
  if (n < 0) return 1.0 / power(a, n == std::numeric_limits<int>::min() ? -(n + 1) : -n);
  const auto degree = static_cast<unsigned>(n);
  if (degree % 2 == 0) return power_of_positive(abs(a), degree);
  if (a.lo >= 0.0) return power_of_positive(a, degree);
  if (a.hi <= 0.0) return -power_of_positive(-a, degree);
  return {-power_of_positive(-a.lo, degree).hi, power_of_positive(a.hi, degree).hi};
}

Interval power(const Interval& a, double p) {
  if (p == 0.0) return a.empty() || a.hi < 0.0 ? Interval::empty_set() : Interval(1.0);
  if (!(p > 0.0 ? a.hi >= 0.0 : a.hi > 0.0)) return Interval::empty_set();
  const double lo = std::pow(std::max(0.0, a.lo), p), hi = std::pow(a.hi, p);
  const double least = std::min(lo, hi), most = std::max(lo, hi);
  return checked(least == 0.0 ? 0.0 : std::max(0.0, library_below(least)), library_above(most), a,
                 a);
}

Interval sqrt(const Interval& a) {
  if (!(a.hi >= 0.0)) return Interval::empty_set();
  return checked(a.lo > 0.0 ? below(std::sqrt(a.lo)) : 0.0, above(std::sqrt(a.hi)), a, a);
}

Interval exp(const Interval& a) {
  return checked(std::max(0.0, library_below(std::exp(a.lo))), library_above(std::exp(a.hi)), a, a);
}

Interval log(const Interval& a) {
  if (!(a.hi > 0.0)) return Interval::empty_set();
  return checked(a.lo > 0.0 ? library_below(std::log(a.lo)) : -kInfinity,
                 library_above(std::log(a.hi)), a, a);
}

Interval sin(const Interval& a) {
  if (a.empty()) return a;
  if (!(a.magnitude() < kLargestPhase)) return {-1.0, 1.0};
  const double slack = 8.0 * kEpsilon * (1.0 + a.magnitude());
  return wave(a.lo / kPi - 0.5 - slack, a.hi / kPi - 0.5 + slack, std::sin(a.lo), std::sin(a.hi));
}

Interval cos(const Interval& a) {
  if (a.empty()) return a;
  if (!(a.magnitude() < kLargestPhase)) return {-1.0, 1.0};
  const double slack = 8.0 * kEpsilon * (1.0 + a.magnitude());
  return wave(a.lo / kPi - slack, a.hi / kPi + slack, std::cos(a.lo), std::cos(a.hi));
}

}  // namespace caustic::geometry
