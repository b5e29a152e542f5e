#include "geometry/enclosed_polynomial.h"

#include <algorithm>

#include "geometry/linear.h"

namespace caustic::geometry {

double LongPolynomial::operator()(double t) const {
  double sum = c[degree];
  for (int i = degree - 1; i >= 0; --i) sum = sum * t + c[i];
  return sum;
}

LongPolynomial LongPolynomial::derivative() const {
  LongPolynomial d;
  d.degree = std::max(0, degree - 1);
  for (int i = 1; i <= degree; ++i) d.c[i - 1] = i * c[i];
  return d;
}

// Synthetic division by w = t' − t, degree times.
LongPolynomial LongPolynomial::about(double t) const {
  LongPolynomial q = *this;
  for (int first = 0; first < degree; ++first) {
    for (int i = degree - 1; i >= first; --i) q.c[i] += t * q.c[i + 1];
  }
  return q;
}

LongPolynomial operator*(const LongPolynomial& a, const LongPolynomial& b) {
  LongPolynomial product;
  product.degree = a.degree + b.degree;
  for (int i = 0; i <= a.degree; ++i) {
    for (int j = 0; j <= b.degree; ++j) product.c[i + j] += a.c[i] * b.c[j];
  }
  return product;
}

std::array<double, 3> EnclosedPolynomial::derivatives(double t) const {
  double f = 0.0, df = 0.0, half_ddf = 0.0;
  for (int i = p_.degree; i >= 0; --i) {
    half_ddf = half_ddf * t + df;
    df = df * t + f;
    f = f * t + p_.c[i];
  }
  return {f, df, 2.0 * half_ddf};
}

void EnclosedPolynomial::expand(double a, double b) const {
  if (a == a_ && b == b_) return;
  a_ = a;
  b_ = b;
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a), reach = std::abs(middle) + half;
  about_ = p_.about(middle);
  double f = 0.0, df = 0.0, half_ddf = 0.0;  // of Σ |c_k| t^k at the farther end
  for (int i = p_.degree; i >= 0; --i) {
    half_ddf = half_ddf * reach + df;
    df = df * reach + f;
    f = f * reach + std::abs(p_.c[i]);
  }
  const double roundings = 4.0 * (p_.degree + 2) * kEpsilon;
  slack_ = {roundings * f, roundings * df, roundings * 2.0 * half_ddf};
}

Interval EnclosedPolynomial::range(int order, double a, double b) const {
  expand(a, b);
  const double half = 0.5 * (b - a);
  Interval r{-slack_[order], slack_[order]};
  double power = 1.0;
  for (int k = order; k <= p_.degree; ++k, power *= half) {
    double term = about_.c[k] * power;
    for (int i = 0; i < order; ++i) term *= k - i;
    if (k == order) {
      r.lo += term;
      r.hi += term;
    } else if ((k - order) % 2 == 0) {
      r.lo += std::min(0.0, term);
      r.hi += std::max(0.0, term);
    } else {
      r.lo -= std::abs(term);
      r.hi += std::abs(term);
    }
  }
  return r.empty() ? Interval::whole() : r;  // overflow says nothing
}

}  // namespace caustic::geometry
