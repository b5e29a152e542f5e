#include "tests/stress/oracle_roots.h"

#include <algorithm>
#include <cmath>

namespace caustic::stress {
namespace {

/// Where to look along a ray for a surface that may be anywhere: densely about the scene.
std::vector<Long> places_along(Long t0, Long t1, Long size) {
  std::vector<Long> t;
  const Long near_end = std::min(t1, t0 + 4.0L * size);
  for (int i = 0; i <= 64; ++i) t.push_back(t0 + (near_end - t0) * i / 64.0L);
  for (Long far = near_end; far < t1;) {
    far = std::min(t1, t0 + 1.4L * (far - t0));
    t.push_back(far);
  }
  return t;
}

}  // namespace

std::vector<Long> surface_roots(const OracleSurface& s, const Stretch& ray, double size,
                                Long slack) {
  const auto& [o, w, t0, t1] = ray;
  const auto f = [&](Long t) { return s.value(o + t * w); };
  const auto [center, radius] = s.ball();
  std::vector<Long> t;
  if (std::isfinite(radius)) {
    const LongVec c = center.cast<Long>() - o;
    const Long middle = c.dot(w), off2 = c.squaredNorm() - middle * middle;
    const Long half2 = Long(radius) * radius * 1.0001L - off2;
    if (half2 < 0.0L) return {};
    const Long a = std::max(t0, middle - std::sqrt(half2)),
               b = std::min(t1, middle + std::sqrt(half2));
    if (a >= b) return {};
    for (int i = 0; i <= 48; ++i) t.push_back(a + (b - a) * i / 48.0L);
  } else {
    t = places_along(t0, t1, size);
  }

  std::vector<Long> found;
  const auto refine = [&](Long a, Long fa, Long b, Long fb) {
    const Long scale = std::max(std::abs(fa), std::abs(fb));
    Long middle = a, value = fa;
    for (int i = 0; i < 200 && b - a > 1e-18L * (std::abs(a) + std::abs(b)); ++i) {
      // The secant's root, kept away from the ends every third time by halving.
      middle = i % 3 == 2 ? 0.5L * (a + b) : a + (b - a) * (fa / (fa - fb));
      if (!(middle > a && middle < b)) middle = 0.5L * (a + b);
      if (middle == a || middle == b) break;
      value = f(middle);
      if (value == 0.0L) break;
      if ((value > 0.0L) == (fa > 0.0L)) {
        a = middle, fa = value;
      } else {
        b = middle, fb = value;
      }
    }
    // Not a pole, and not where the reference changes from one function to another.
    if (std::min(std::abs(fa), std::abs(fb)) <= 1e-9L * scale || value == 0.0L)
      found.push_back(middle);
  };
  std::vector<Long> v;
  for (const Long place : t) v.push_back(f(place));
  for (std::size_t i = 0; i + 1 < t.size(); ++i) {
    if (std::isnan(v[i]) || std::isnan(v[i + 1])) continue;
    if ((v[i] > 0.0L) != (v[i + 1] > 0.0L)) {
      refine(t[i], v[i], t[i + 1], v[i + 1]);
    } else if (i > 0 && !std::isnan(v[i - 1]) && std::abs(v[i]) <= std::abs(v[i - 1]) &&
               std::abs(v[i]) <= std::abs(v[i + 1])) {
      // A dip may hide a pair of roots.
      Long a = t[i - 1], b = t[i + 1];
      const Long sign = v[i] > 0.0L ? 1.0L : -1.0L;
      for (int k = 0; k < 48; ++k) {
        const Long p = a + 0.382L * (b - a), q = a + 0.618L * (b - a);
        const Long fp = sign * f(p), fq = sign * f(q);
        if (fp < 0.0L || fq < 0.0L) {
          const Long at = fp < 0.0L ? p : q;
          refine(t[i - 1], v[i - 1], at, f(at));
          refine(at, f(at), t[i + 1], v[i + 1]);
          break;
        }
        (fp < fq ? b : a) = fp < fq ? q : p;
      }
    }
  }
  std::sort(found.begin(), found.end());
  std::erase_if(found, [&](Long root) { return s.excess(o + root * w) > slack; });
  return found;
}

}  // namespace caustic::stress
