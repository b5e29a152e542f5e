#include "solver/rings.h"

#include <cmath>

namespace caustic::solver {

namespace {

using geometry::Vec2;

// From the way back along `arrives`, clockwise to `leaves`: in (0, 2π].
double clockwise(const Vec2& arrives, const Vec2& leaves) {
  const Vec2 back = -arrives;
  const double angle = std::atan2(back.x() * leaves.y() - back.y() * leaves.x(), back.dot(leaves));
  return angle < 0.0 ? -angle : 2.0 * geometry::kPi - angle;
}

}  // namespace

Rings join_rings(const std::vector<RingArc>& arcs, double near) {
  Rings rings{std::vector<int>(arcs.size(), -1), std::vector<int>(arcs.size(), -1), 0};
  const auto next_of = [&](std::size_t k) {
    std::size_t best = arcs.size();
    double least = geometry::kInfinity;
    for (std::size_t i = 0; i < arcs.size(); ++i) {
      if (arcs[i].closed || (arcs[i].begin - arcs[k].end).norm() > near) continue;
      const double angle = clockwise(arcs[k].arrives, arcs[i].leaves);
      if (angle < least) least = angle, best = i;
    }
    return best;
  };
  int id = 0;
  for (std::size_t first = 0; first < arcs.size(); ++first) {
    if (rings.id[first] >= 0) continue;
    int order = 0;
    std::size_t k = first;
    do {
      rings.id[k] = id;
      rings.order[k] = order++;
      k = arcs[k].closed ? first : next_of(k);
    } while (k != arcs.size() && rings.id[k] < 0);
    rings.open += k != first;
    ++id;
  }
  return rings;
}

}  // namespace caustic::solver
