#include "solver/cell_clipper.h"

#include <algorithm>
#include <cmath>

#include "geometry/root_finding.h"

namespace caustic::solver {

namespace {

// Halvings of an edge until the last place with a path is known.
constexpr int kPathEndHalvings = 24;
// Corners on the domain's boundary are as near to it as this share of the edge they cut.
constexpr double kClipShare = 1e-4;
// The bounds of a chart's cell are numbered from here downwards, next to the domain's boundaries.
constexpr int kFirstOfCell = -3;

}  // namespace

// The last place on the way from a to b, where no path arrives, that a path comes from.
Corner CellClipper::path_end(int chart, const Corner& a, const Corner& b) {
  Vec2 inside(a.s, a.t), outside(b.s, b.t);
  Corner last = a;
  for (int i = 0; i < kPathEndHalvings; ++i) {
    const Vec2 middle = 0.5 * (inside + outside);
    const FieldPoint f = evaluate_(e_.charts[chart].point(middle.x(), middle.y()));
    (f.finite ? inside : outside) = middle;
  }
  if (inside != Vec2(a.s, a.t)) {
    last = {inside.x(), inside.y(), add_sample(e_, evaluate_, chart, inside.x(), inside.y())};
  }
  return last;
}

// The part of a polygon that paths come from.
std::vector<Corner> CellClipper::clip_path_ends(int chart, const std::vector<Corner>& polygon) {
  const auto finite = [&](const Corner& corner) { return e_.samples[corner.sample].finite; };
  if (std::all_of(polygon.begin(), polygon.end(), finite)) return polygon;
  std::vector<Corner> kept;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Corner a = polygon[k], b = polygon[(k + 1) % polygon.size()];
    if (finite(a)) kept.push_back(a);
    if (finite(a) == finite(b)) continue;
    kept.push_back(finite(a) ? path_end(chart, a, b) : path_end(chart, b, a));
    kept.back().boundary = finite(a) ? kPathEnds : -1;
  }
  return kept;
}

// A boundary of the domain, or of the chart's cell from kFirstOfCell downwards.
const geometry::Bound* CellClipper::bound(int boundary, int chart) const {
  return boundary < 0 ? &e_.charts[chart].cell[kFirstOfCell - boundary] : domain_.bound(boundary);
}

double CellClipper::height(int boundary, int chart, const FieldPoint& f) const {
  const geometry::Bound* b = bound(boundary, chart);
  return b ? b->value(f.x) : domain_.value(boundary, f);
}

// Where the edge between two corners crosses a boundary; once for both of its cells.
Corner CellClipper::crossing(int boundary, int chart, const Corner& a, const Corner& b) {
  const auto h = [&](const FieldPoint& f) { return height(boundary, chart, f); };
  const auto place = [&](double w) { return Vec2(a.s + w * (b.s - a.s), a.t + w * (b.t - a.t)); };
  const auto [lo, hi] = std::minmax(a.sample, b.sample);
  const auto [known, fresh] = crossings_.try_emplace(std::array{lo, hi, boundary}, Corner{});
  if (!fresh) return known->second;
  const geometry::Bound* of_place = bound(boundary, chart);
  const auto value = [&](double w) {
    const Vec2 at = place(w);
    const Point x = e_.charts[chart].point(at.x(), at.y());
    if (of_place) return of_place->value(x);
    const FieldPoint f = evaluate_(x);
    return f.finite ? h(f) : 0.0;
  };
  const double ha = h(e_.samples[a.sample]), hb = h(e_.samples[b.sample]);
  double w = ha == 0.0 ? 0.0 : hb == 0.0 ? 1.0 : 0.5;
  if (ha != 0.0 && hb != 0.0) {
    const double small = kClipShare * (std::abs(ha) + std::abs(hb));
    w = geometry::illinois_root(
        value, [&](double, double v) { return std::abs(v) <= small; }, 0.0, 1.0, ha, hb);
  }
  const Vec2 at = place(w);
  known->second = {at.x(), at.y(), add_sample(e_, evaluate_, chart, at.x(), at.y())};
  return known->second;
}

// The part of a polygon inside one boundary; new corners lie on it.
void CellClipper::clip_at(int boundary, int chart, std::vector<Corner>& polygon) {
  const auto h = [&](const Corner& corner) {
    return height(boundary, chart, e_.samples[corner.sample]);
  };
  const auto inside = [&](const Corner& corner) { return h(corner) <= 0.0; };
  if (std::all_of(polygon.begin(), polygon.end(), inside)) return;
  std::vector<Corner> kept;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Corner a = polygon[k], b = polygon[(k + 1) % polygon.size()];
    const bool a_inside = inside(a), b_inside = inside(b);
    if (a_inside) kept.push_back(a);
    if (a_inside == b_inside) continue;
    const Corner cut = crossing(boundary, chart, a, b);
    // Where paths end on the way there is no such place.
    const double across = std::abs(h(a)) + std::abs(h(b));
    if (!e_.samples[cut.sample].finite || std::abs(h(cut)) > 0.1 * across) continue;
    kept.push_back(cut);
    // On the way out the polygon goes on along the boundary, on the way in along the old edge.
    kept.back().boundary = !a_inside ? a.boundary : boundary < 0 ? -1 : boundary;
  }
  polygon.swap(kept);
}

// The part of a polygon inside the chart's cell and the domain.
std::vector<Corner> CellClipper::operator()(int chart, std::vector<Corner> polygon) {
  polygon = clip_path_ends(chart, polygon);
  const int cell_bounds = static_cast<int>(e_.charts[chart].cell.size());
  for (int k = 0; k < cell_bounds; ++k) clip_at(kFirstOfCell - k, chart, polygon);
  for (int boundary = 0; boundary < domain_.size() && !polygon.empty(); ++boundary) {
    clip_at(boundary, chart, polygon);
  }
  return polygon.size() < 3 ? std::vector<Corner>{} : polygon;
}

}  // namespace caustic::solver
