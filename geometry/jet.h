// Second-order jets in two directions: a value with its derivatives along s and t, up to second
// order. Arithmetic on them is differentiation in closed form; six numbers a scalar, or six of
// whatever scales and adds like one, such as a pair of coordinates.
#pragma once

#include <cmath>

namespace caustic::geometry {

template <class T>
struct JetOf {
  T v, s, t, ss, st, tt;
};
using Jet = JetOf<double>;

template <class T>
inline JetOf<T> operator+(const JetOf<T>& a, const JetOf<T>& b) {
  return {a.v + b.v, a.s + b.s, a.t + b.t, a.ss + b.ss, a.st + b.st, a.tt + b.tt};
}
template <class T>
inline JetOf<T> operator-(const JetOf<T>& a, const JetOf<T>& b) {
  return {a.v - b.v, a.s - b.s, a.t - b.t, a.ss - b.ss, a.st - b.st, a.tt - b.tt};
}
template <class T>
inline JetOf<T> operator*(double k, const JetOf<T>& a) {
  return {k * a.v, k * a.s, k * a.t, k * a.ss, k * a.st, k * a.tt};
}
template <class K, class T>
inline JetOf<T> operator*(const JetOf<K>& a, const JetOf<T>& b) {
  return {a.v * b.v,
          a.v * b.s + a.s * b.v,
          a.v * b.t + a.t * b.v,
          a.v * b.ss + 2.0 * a.s * b.s + a.ss * b.v,
          a.v * b.st + a.s * b.t + a.t * b.s + a.st * b.v,
          a.v * b.tt + 2.0 * a.t * b.t + a.tt * b.v};
}
/// Quotient from a = r b: r_s = (a_s − r b_s)/b, r_ss = (a_ss − 2 r_s b_s − r b_ss)/b, …
template <class K>
inline JetOf<K> operator/(const JetOf<K>& a, const JetOf<K>& b) {
  const K inverse = 1.0 / b.v;
  JetOf<K> r;
  r.v = a.v * inverse;
  r.s = (a.s - r.v * b.s) * inverse;
  r.t = (a.t - r.v * b.t) * inverse;
  r.ss = (a.ss - 2.0 * r.s * b.s - r.v * b.ss) * inverse;
  r.st = (a.st - r.s * b.t - r.t * b.s - r.v * b.st) * inverse;
  r.tt = (a.tt - 2.0 * r.t * b.t - r.v * b.tt) * inverse;
  return r;
}

/// Root of a jet with a positive value, from r² = a.
template <class K>
inline JetOf<K> sqrt(const JetOf<K>& a) {
  using std::sqrt;
  const K root = sqrt(a.v), half = 0.5 / root;
  JetOf<K> r;
  r.v = root;
  r.s = half * a.s;
  r.t = half * a.t;
  r.ss = half * (a.ss - 2.0 * r.s * r.s);
  r.st = half * (a.st - 2.0 * r.s * r.t);
  r.tt = half * (a.tt - 2.0 * r.t * r.t);
  return r;
}
/// Scalar product of two vectors of jets.
template <class T>
inline Jet dot(const JetOf<T>& a, const JetOf<T>& b) {
  return {a.v.dot(b.v),
          a.v.dot(b.s) + a.s.dot(b.v),
          a.v.dot(b.t) + a.t.dot(b.v),
          a.v.dot(b.ss) + 2.0 * a.s.dot(b.s) + a.ss.dot(b.v),
          a.v.dot(b.st) + a.s.dot(b.t) + a.t.dot(b.s) + a.st.dot(b.v),
          a.v.dot(b.tt) + 2.0 * a.t.dot(b.t) + a.tt.dot(b.v)};
}

}  // namespace caustic::geometry
