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

  const Polynomial d = p.derivative();
  const std::size_t first = out.size();
  std::vector<double> cuts{t0};
  real_roots(d, t0, t1, cuts);
  cuts.push_back(t1);
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const double a = cuts[i], b = cuts[i + 1], fa = p(a), fb = p(b);
    if (fa == 0.0) {
      if (i == 0 || p(cuts[i - 1]) != 0.0) out.push_back(a);
    } else if (fb != 0.0 && (fa > 0.0) != (fb > 0.0)) {
      out.push_back(bracketed_root(p, d, a, b, fa));
    }
  }
  const bool listed = out.size() > first && out.back() == t1;
  if (!listed && p(t1) == 0.0) out.push_back(t1);
}

}  // namespace caustic::geometry
