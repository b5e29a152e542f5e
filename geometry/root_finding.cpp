#include "geometry/root_finding.h"

#include <algorithm>

namespace caustic::geometry {

namespace {

// Bernstein coefficients below this share of what they are sums of may have either sign.
constexpr double kSignShare = 1e-13;

// Citardauq: the larger root by adding what has the same sign, the other from the product.
void quadratic_roots(const Polynomial& p, double t0, double t1, std::vector<double>& out) {
  const double a = p.c[2], h = 0.5 * p.c[1], c = p.c[0];
  const double discriminant = h * h - a * c;
  if (!(discriminant >= 0.0)) return;
  const double w = -(h + std::copysign(std::sqrt(discriminant), h));
  double r0 = w / a, r1 = w != 0.0 ? c / w : r0;
  if (r0 > r1) std::swap(r0, r1);
  if (r0 >= t0 && r0 <= t1) out.push_back(r0);
  if (r1 >= t0 && r1 <= t1 && r1 != r0) out.push_back(r1);
}

// Changes of sign in the Bernstein coefficients on [t0, t1], which the number of roots there is at
// most, and differs from by an even number (Descartes' rule); −1 where rounding leaves a sign open.
int sign_changes(const Polynomial& p, double t0, double t1) {
  const double h = t1 - t0;
  if (!std::isfinite(h)) return -1;
  // Taylor coefficients at t0 by repeated synthetic division, and how large what is added up is.
  std::array<double, 5> c = p.c;
  double size = 0.0;
  const double reach = std::max(std::abs(t0), std::abs(t1));
  for (int i = p.degree; i >= 0; --i) size = size * reach + std::abs(c[i]);
  for (int i = 0; i < p.degree; ++i) {
    for (int k = p.degree - 1; k >= i; --k) c[k] += t0 * c[k + 1];
  }
  // Σ_k C(i,k)/C(n,k) c_k h^k by differences: scaled coefficients, summed up i times.
  double power = 1.0, binomial = 1.0;
  for (int k = 0; k <= p.degree; ++k) {
    c[k] *= power / binomial;
    power *= h;
    binomial = binomial * (p.degree - k) / (k + 1);
  }
  const double open = kSignShare * size;
  int changes = 0;
  bool last = c[0] > 0.0;
  for (int i = 0; i <= p.degree; ++i) {
    if (!(std::abs(c[0]) > open)) return -1;
    changes += (c[0] > 0.0) != last;
    last = c[0] > 0.0;
    for (int k = 0; k < p.degree - i; ++k) c[k] += c[k + 1];
  }
  return changes;
}

}  // namespace

void real_roots(const Polynomial& given, double t0, double t1, std::vector<double>& out) {
  Polynomial p = given;
  while (p.degree > 0 && p.c[p.degree] == 0.0) --p.degree;
  if (p.degree == 0) return;
  if (p.degree == 1) {
    const double r = -p.c[0] / p.c[1];
    if (r >= t0 && r <= t1) out.push_back(r);
    return;
  }
  if (p.degree == 2) return quadratic_roots(p, t0, t1, out);

  const Polynomial d = p.derivative();
  const int changes = sign_changes(p, t0, t1);
  if (changes == 0) return;
  if (changes == 1) {
    out.push_back(bracketed_root(p, d, t0, t1, p(t0)));
    return;
  }
  // Monotone between neighbouring roots of the derivative. The cuts share `out` as a scratch stack.
  const std::size_t first = out.size();
  out.push_back(t0);
  real_roots(d, t0, t1, out);
  out.push_back(t1);
  std::array<double, 6> cuts{};
  const std::size_t count = std::min(out.size() - first, cuts.size());
  std::copy_n(out.begin() + static_cast<std::ptrdiff_t>(first), count, cuts.begin());
  out.resize(first);

  double fa = p(cuts[0]), before = 1.0;
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const double a = cuts[i], b = cuts[i + 1], fb = p(b);
    if (fa == 0.0) {
      if (before != 0.0) out.push_back(a);
    } else if (fb != 0.0 && (fa > 0.0) != (fb > 0.0)) {
      out.push_back(bracketed_root(p, d, a, b, fa));
    }
    before = fa;
    fa = fb;
  }
  const bool listed = out.size() > first && out.back() == t1;
  if (!listed && fa == 0.0) out.push_back(t1);
}

}  // namespace caustic::geometry
