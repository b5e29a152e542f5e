#include "solver/gap_search.h"

#include <algorithm>

namespace caustic::solver {

namespace {

// Parts this many halvings smaller than a cell are taken for hidden if their middle is.
constexpr int kGapDepth = 2;

struct Part {  // of a cell, in its chart
  int chart;
  Vec2 middle, half;
  int depth;
};

Part part_about(const Cell& cell) {
  Vec2 lo(1.0, 1.0), hi(0.0, 0.0);
  for (const Corner& corner : cell.polygon) {
    lo = lo.cwiseMin(Vec2(corner.s, corner.t));
    hi = hi.cwiseMax(Vec2(corner.s, corner.t));
  }
  return {cell.chart, 0.5 * (lo + hi), 0.5 * (hi - lo), 0};
}

// The path that arrives from x + dx, to first order.
LightPath moved(const ForwardMap& map, const FieldPoint& f, const Vec3& dx) {
  LightPath path(map, f);
  const double ds = f.e1.dot(dx), dt = f.e2.dot(dx);
  path.at[0] += dx;
  for (int k = 1; k < map.hop_count(); ++k) {
    path.at[k] += ds * f.hits[k].y_s + dt * f.hits[k].y_t;
  }
  path.at[map.hop_count()] = map.receiver().point(f.q + f.push_forward(dx));
  return path;
}

}  // namespace

bool shows_through_gap(Evaluator& evaluate, const Domain& domain, const Exploration& e,
                       const Visibility& visibility, const Hops& hops) {
  const ForwardMap& map = evaluate.map();
  std::vector<Part> parts;
  for (const Cell& cell : e.cells) parts.push_back(part_about(cell));
  while (!parts.empty() && !evaluate.budget().exhausted()) {
    const Part part = parts.back();
    parts.pop_back();
    const auto& chart = e.charts[part.chart];
    const FieldPoint f = evaluate(chart.point(part.middle.x(), part.middle.y()));
    if (domain.contains(f)) {
      const LightPath path(map, f);
      const Sight sight = visibility.look(hops, path);
      if (!sight.hidden) return true;
      const auto covers = [&](double i, double j) {
        const Point corner =
            chart.point(part.middle.x() + i * part.half.x(), part.middle.y() + j * part.half.y());
        return sight.used(path, moved(map, f, corner - f.x)) < kUsableRoom;
      };
      if (covers(-1, -1) && covers(1, -1) && covers(1, 1) && covers(-1, 1)) continue;
    }
    if (part.depth == kGapDepth) continue;
    const Vec2 half = 0.5 * part.half;
    for (const double i : {-1.0, 1.0}) {
      for (const double j : {-1.0, 1.0}) {
        parts.push_back(
            {part.chart, part.middle + Vec2(i * half.x(), j * half.y()), half, part.depth + 1});
      }
    }
  }
  return false;
}

}  // namespace caustic::solver
