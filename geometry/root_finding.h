// Real roots on an interval: of polynomials, and of any function whose range can be bounded.
#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <utility>
#include <vector>

#include "geometry/interval.h"

namespace caustic::geometry {

/// c[0] + c[1] t + … + c[degree] t^degree, degree ≤ 4.
struct Polynomial {
  std::array<double, 5> c{};
  int degree = 0;

  double operator()(double t) const {
    double sum = c[degree];
    for (int i = degree - 1; i >= 0; --i) sum = sum * t + c[i];
    return sum;
  }
  Polynomial derivative() const {
    Polynomial d;
    d.degree = degree > 0 ? degree - 1 : 0;
    for (int i = 1; i <= degree; ++i) d.c[i - 1] = i * c[i];
    return d;
  }
};

/// Root of f in [a, b] where f(a) and f(b) have opposite signs, to some last bits: Newton's method
/// kept inside a shrinking bracket, halved where Newton would leave it or its steps do not halve.
template <class F, class DF>
double bracketed_root(const F& f, const DF& df, double a, double b, double fa) {
  const double smallest = 1e-17 * (b - a);
  double t = 0.5 * (a + b), last_step = 2.0 * (b - a);
  for (int i = 0; i < 200; ++i) {
    const double ft = f(t);
    if (ft == 0.0) return t;
    ((ft > 0.0) == (fa > 0.0) ? a : b) = t;
    double step = -ft / df(t);
    const bool newton = t + step > a && t + step < b && std::abs(step) <= 0.5 * last_step;
    if (!newton) step = 0.5 * (a + b) - t;
    // After a halving Newton's method may go where it wants in the bracket.
    last_step = newton ? std::abs(step) : 2.0 * (b - a);
    t += step;
    if (std::abs(step) <= 4e-16 * std::abs(t) + smallest) return t;
  }
  return t;
}

/// Root of f in [a, b], f(a) = fa and f(b) = fb of opposite signs, without derivatives: the Illinois
/// variant of regula falsi. Stops when `done(t, ft)` says so or the bracket is down to rounding.
template <class F, class Done>
double illinois_root(const F& f, const Done& done, double a, double b, double fa, double fb) {
  int last = 0;
  for (int i = 0; i < 100; ++i) {
    double t = b - fb * (b - a) / (fb - fa);
    if (!(t > a && t < b) || i % 10 == 9) t = 0.5 * (a + b);
    if (!(t > a && t < b)) return t;
    const double ft = f(t);
    if (ft == 0.0 || done(t, ft)) return t;
    if ((ft > 0.0) == (fa > 0.0)) {
      a = t;
      fa = ft;
      if (last == 1) fb *= 0.5;
      last = 1;
    } else {
      b = t;
      fb = ft;
      if (last == -1) fa *= 0.5;
      last = -1;
    }
  }
  return 0.5 * (a + b);
}

/// All real roots in [t0, t1], appended in increasing order. Between neighbouring roots of the
/// derivative a polynomial is monotone, so none is missed; a root where it only touches zero may
/// or may not be listed (rounding decides). Identically zero polynomials have no roots here.
void real_roots(const Polynomial& p, double t0, double t1, std::vector<double>& out);

/// A function with two derivatives, as values f(t), df(t), ddf(t) and as enclosures over intervals.
template <class F>
concept EnclosedFunction = requires(const F& h, double t) {
  { h.f(t) } -> std::convertible_to<double>;
  { h.df(t) } -> std::convertible_to<double>;
  { h.ddf(t) } -> std::convertible_to<double>;
  { h.range_f(t, t) } -> std::convertible_to<Interval>;
  { h.range_df(t, t) } -> std::convertible_to<Interval>;
  { h.range_ddf(t, t) } -> std::convertible_to<Interval>;
};

/// All roots of h in [t0, t1], appended in increasing order. Subintervals are halved until h has no
/// zero there, or is monotone, or has a derivative that is monotone: then it has two roots at most,
/// on either side of where it is stationary. (Without the last rule the work about a nearly triple
/// root, a ray that leaves along an asymptotic direction, grows with the inverse of its distance.)
/// Subintervals narrower than 1e-13 of the whole that stay undecided hold a multiple root at most and
/// are dropped; so is what is left after kMaxIntervals, when h is zero to rounding over a stretch.
template <EnclosedFunction H>
void isolated_roots(const H& h, double t0, double t1, std::vector<double>& out) {
  constexpr int kMaxIntervals = 50000;
  const auto f = [&](double t) { return h.f(t); };
  const auto df = [&](double t) { return h.df(t); };
  const auto ddf = [&](double t) { return h.ddf(t); };
  // A root at b belongs to the next interval, unless there is none.
  const auto monotone = [&](double a, double b) {
    const double fa = f(a), fb = f(b);
    if (fa == 0.0) {
      out.push_back(a);
    } else if (fb == 0.0) {
      if (b == t1) out.push_back(b);
    } else if ((fa > 0.0) != (fb > 0.0)) {
      out.push_back(bracketed_root(f, df, a, b, fa));
    }
  };
  std::vector<std::pair<double, double>> stack{{t0, t1}};
  const double smallest = 1e-13 * (t1 - t0);
  for (int seen = 0; !stack.empty() && seen < kMaxIntervals; ++seen) {
    const auto [a, b] = stack.back();
    stack.pop_back();
    if (!h.range_f(a, b).contains_zero()) continue;
    if (!h.range_df(a, b).contains_zero()) {
      monotone(a, b);
      continue;
    }
    if (!h.range_ddf(a, b).contains_zero()) {
      const double da = df(a), db = df(b);
      if (da == 0.0 || db == 0.0 || (da > 0.0) == (db > 0.0)) {
        monotone(a, b);
      } else {
        const double turn = bracketed_root(df, ddf, a, b, da);
        monotone(a, turn);
        monotone(turn, b);
      }
      continue;
    }
    if (b - a <= smallest) continue;
    const double middle = 0.5 * (a + b);
    stack.push_back({middle, b});
    stack.push_back({a, middle});
  }
}

}  // namespace caustic::geometry
