#include "geometry/root_finding.h"

#include <algorithm>

namespace caustic::geometry {

namespace {

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

  // Monotone between neighbouring roots of the derivative. The cuts share `out` as a scratch stack.
  const Polynomial d = p.derivative();
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
