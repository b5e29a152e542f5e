// The functions of expressions on numbers and on intervals, one table for folding and running.
#pragma once

#include <cmath>
#include <limits>

#include "geometry/expression/graph.h"
#include "geometry/interval.h"

namespace caustic::geometry {

inline double sign_of(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : x; }
inline double kink_of(double x) { return 0.0 * x; }

inline Interval sign_of(const Interval& x) {
  return x.empty() ? x : Interval(x.lo > 0.0 ? 1.0 : -1.0, x.hi < 0.0 ? -1.0 : 1.0);
}
/// Beside zero sign is constant; over zero it jumps, which only an unbounded slope encloses.
inline Interval kink_of(const Interval& x) {
  return x.empty() ? x : x.contains_zero() ? Interval::whole() : Interval(0.0);
}

/// A function of one operand and its constant. Not for add, multiply, constant and variable.
template <class T>
T apply_function(Term function, const T& a, double c) {
  using std::abs, std::cos, std::exp, std::log, std::sin, std::sqrt;
  switch (function) {
    case Term::reciprocal:
      return 1.0 / a;
    case Term::power:
      if constexpr (std::is_same_v<T, double>)
        return std::pow(a, c);
      else
        return power(a, c);
    case Term::sqrt:
      return sqrt(a);
    case Term::sin:
      return sin(a);
    case Term::cos:
      return cos(a);
    case Term::exp:
      return exp(a);
    case Term::log:
      return log(a);
    case Term::abs:
      return abs(a);
    case Term::sign:
      return sign_of(a);
    case Term::kink:
      return kink_of(a);
    default:
      return std::numeric_limits<double>::quiet_NaN();
  }
}

/// True if the function is defined and continuous on all of a.
inline bool defined_on(Term function, const Interval& a, double c) {
  switch (function) {
    case Term::reciprocal:
      return !a.contains_zero();
    case Term::power:
      return c > 0.0 ? a.lo >= 0.0 : a.lo > 0.0;
    case Term::sqrt:
      return a.lo >= 0.0;
    case Term::log:
      return a.lo > 0.0;
    default:
      return true;
  }
}

}  // namespace caustic::geometry
