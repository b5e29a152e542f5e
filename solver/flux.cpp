#include "solver/flux.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace caustic::solver {

namespace {

// Unit tangent of a cell's edge at one of its corners, towards `along`: of the domain's boundary,
// or of the chart's line.
Vec3 edge_tangent(const Exploration& e, const Cell& cell, const Domain& domain, int boundary,
                  const Corner& at, const Vec2& step, const Vec3& along) {
  const FieldPoint& f = e.samples[at.sample];
  Vec3 t;
  if (boundary == kPathEnds) return along.normalized();
  if (boundary >= 0) {
    t = f.n.cross(domain.gradient(boundary, f));
  } else {
    const Vec2 h = 1e-4 * step;
    t = e.charts[cell.chart].point(at.s + h.x(), at.t + h.y()) - f.x;
  }
  return t.normalized() * std::copysign(1.0, t.dot(along));
}

// Mean distance, times its direction, of a curve from its chord of length L: L (T₀ − T₁)/12 by the
// cubic with unit tangents T₀, T₁, corrected so that it is exact for arcs of any angle θ.
Vec3 mean_bulge(double length, const Vec3& t0, const Vec3& t1) {
  const Vec3 turn = t0 - t1;
  const double sine = std::min(1.0, 0.5 * turn.norm()), angle = 2.0 * std::asin(sine);
  const double arc = angle > 0.1 ? 0.75 * (angle - std::sin(angle)) / (sine * sine * sine) : 1.0;
  return (arc * length / 12.0) * turn;
}

}  // namespace

// With the sign of the polygon's orientation.
double FluxSum::through_polygon(const Cell& cell) const {
  const double strength = domain_.map().strength();
  const Point& first = e_.samples[cell.polygon[0].sample].x;
  double sum = 0.0;
  for (std::size_t k = 1; k + 1 < cell.polygon.size(); ++k) {
    const Point& b = e_.samples[cell.polygon[k].sample].x;
    const Point& c = e_.samples[cell.polygon[k + 1].sample].x;
    if (const auto* point = std::get_if<PointLight>(&light_)) {
      // Solid angle of a triangle: Van Oosterom & Strackee, IEEE Trans. BME 30 (1983).
      const Vec3 u = (first - point->position).normalized(), v = (b - point->position).normalized(),
                 w = (c - point->position).normalized();
      sum += 2.0 * strength * std::atan2(u.dot(v.cross(w)), 1.0 + u.dot(v) + v.dot(w) + w.dot(u));
    } else {
      const auto& beam = std::get<CollimatedLight>(light_);
      sum += 0.5 * strength * (b - first).cross(c - first).dot(beam.direction);
    }
  }
  return sum;
}

// Through the ribbon between the curve and the chord, on the edge's left as its cell goes round.
double FluxSum::beyond_chord(const Edge& edge) const {
  const auto& polygon = edge.cell->polygon;
  const Corner &a = polygon[edge.k], &b = polygon[(edge.k + 1) % polygon.size()];
  const Point &xa = e_.samples[a.sample].x, &xb = e_.samples[b.sample].x;
  const Vec3 chord = xb - xa;
  const Vec2 step(b.s - a.s, b.t - a.t);
  const Vec3 bulge =
      mean_bulge(chord.norm(), edge_tangent(e_, *edge.cell, domain_, a.boundary, a, step, chord),
                 edge_tangent(e_, *edge.cell, domain_, a.boundary, b, step, chord));
  const Point middle = 0.5 * (xa + xb);
  const Vec3 light =
      domain_.map().flux_across(middle) * domain_.map().incident(middle).normalized();
  const double flux = light.dot(bulge.cross(chord));
  return std::isfinite(flux) ? flux : 0.0;
}

void FluxSum::add(const Cell& cell, double weight) {
  double share = 0.0;
  for (const Corner& corner : cell.polygon) share += e_.samples[corner.sample].share;
  weight *= share / static_cast<double>(cell.polygon.size());
  const double flux = through_polygon(cell);
  through_polygons_ += weight * std::abs(flux);
  const double turn = std::copysign(weight, flux);
  for (std::size_t k = 0; k < cell.polygon.size(); ++k) {
    const int a = cell.polygon[k].sample, b = cell.polygon[(k + 1) % cell.polygon.size()].sample;
    edges_.push_back({std::min(a, b), std::max(a, b), a < b ? turn : -turn, &cell, k});
  }
}

// What one cell gains beyond an edge its neighbour loses; only where that is not taken, or weighs
// otherwise, or has other edges there, is anything left.
double FluxSum::value() const {
  std::vector<Edge> edges = edges_;
  std::sort(edges.begin(), edges.end(), [](const Edge& p, const Edge& q) {
    return std::tie(p.lo, p.hi, p.cell) < std::tie(q.lo, q.hi, q.cell);
  });
  double sum = through_polygons_;
  for (std::size_t i = 0; i < edges.size();) {
    const Edge& first = edges[i];
    double weight = 0.0;
    for (; i < edges.size() && edges[i].lo == first.lo && edges[i].hi == first.hi; ++i) {
      weight += edges[i].weight;
    }
    if (weight == 0.0) continue;
    const bool forward = first.cell->polygon[first.k].sample == first.lo;
    sum += (forward ? weight : -weight) * beyond_chord(first);
  }
  return sum;
}

}  // namespace caustic::solver
