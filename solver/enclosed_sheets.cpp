#include "solver/enclosed_sheets.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "geometry/narrowed.h"

namespace caustic::solver {

using geometry::GraphChart;
using geometry::IntervalVec3;

namespace {

// A cluster's box is widened by these shares of its own width and of its largest, so that
// Krawczyk's operator ends inside.
constexpr double kWiden = 0.2;
constexpr double kWidenAll = 0.02;
// Rounds that narrow a sheet's box, and the share that is worth another.
constexpr int kSheetRounds = 4;
constexpr double kNarrowShare = 0.7;
// Images of cells are at most these shares of a rectangle: smaller ones only where larger ones do
// not tell.
constexpr std::array kImageShares{4.0, 1.5, 0.6};
// Where to look for a sheet is guessed to this share of the rectangle, or of a cell's image.
constexpr double kGuessedShare = 1e-2;
constexpr int kSheetSteps = 8;

Interval widened(const Interval& a, double by) { return {a.lo - by, a.hi + by}; }
bool inside(const Interval& a, const Interval& b) { return a.lo > b.lo && a.hi < b.hi; }

bool contains(const IntervalVec3& a, const IntervalVec3& b) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (!a[i].contains(b[i])) return false;
  }
  return true;
}

bool touch(const IntervalVec3& a, const IntervalVec3& b) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (intersection(a[i], b[i]).empty()) return false;
  }
  return true;
}

// Cells that hang together.
struct Cluster {
  IntervalVec3 box;
  std::vector<int> cells;
};

std::vector<Cluster> clusters_of(const MirrorCells& mirror, const std::vector<int>& cells) {
  std::vector<Cluster> clusters;
  for (const int i : cells) {
    Cluster next{mirror.box(i), {i}};
    const IntervalVec3 own = next.box;
    std::erase_if(clusters, [&](Cluster& c) {
      const bool near = touch(c.box, own) &&
                        std::any_of(c.cells.begin(), c.cells.end(),
                                    [&](int other) { return touch(mirror.box(other), own); });
      if (!near) return false;
      for (std::size_t k = 0; k < 3; ++k) next.box[k] = hull(next.box[k], c.box[k]);
      next.cells.insert(next.cells.end(), c.cells.begin(), c.cells.end());
      return true;
    });
    clusters.push_back(std::move(next));
  }
  return clusters;
}

// What can be said of a cluster whose sheets are not told apart; nothing if that is no use.
std::optional<NearCaustic> near_caustic(MirrorCells& mirror, const Cluster& cluster) {
  NearCaustic near{
      cluster.cells, false, true, true, geometry::kInfinity, mirror[cluster.cells[0]].steep};
  for (const int i : cluster.cells) {
    const MirrorCell& cell = mirror[i];
    near.least = std::min(near.least, cell.least);
    near.inside &= cell.inside;
    near.folds |= cell.sign != mirror[cluster.cells[0]].sign || cell.sign == 0;
    for (std::size_t c = 0; c < 2; ++c) {
      MirrorCell::Steep& all = near.steep[c];
      if (all.sign != cell.steep[c].sign) all = {};
      all.least = std::min(all.least, cell.steep[c].least);
    }
  }
  if (!(near.least > 0.0) && !near.grows()) return std::nullopt;
  near.clear = mirror.passage(cluster.cells) == Passage::clear;
  return near;
}

// A chart over the box in which the surface is one graph; nothing if it is none.
std::optional<GraphChart> chart_over(const geometry::Surface& shape, const IntervalVec3& box,
                                     GraphCell& cell) {
  IntervalVec3 middle = box;
  for (Interval& x : middle) x = x.middle();
  const IntervalVec3 N = shape.enclose(middle).gradient;
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (N[static_cast<std::size_t>(k)].magnitude() > N[static_cast<std::size_t>(axis)].magnitude())
      axis = k;
  }
  GraphChart chart{axis, box, {}};
  const std::size_t i = chart.first(), j = chart.second(), k = chart.along();
  const double rise =
      (std::abs(N[i].middle()) * box[i].width() + std::abs(N[j].middle()) * box[j].width()) /
      std::abs(N[k].middle());
  chart.reach = widened(box[k], rise + box[k].width());
  if (!chart.reach.bounded()) return std::nullopt;
  chart.own[k] = chart.reach;
  IntervalVec3 reach = box;
  reach[k] = chart.reach;
  if (shape.enclose(reach).gradient[k].contains_zero() &&
      geometry::narrowed(shape, reach).gradient[k].contains_zero())
    return std::nullopt;
  cell = {box[i], box[j], chart.reach, false};
  if (!narrow(shape, chart, cell) || !cell.whole) return std::nullopt;
  return chart;
}

// Krawczyk's operator of q(s, t) = q for all q of the rectangle at once (S77).
struct Operator {
  Interval s, t;
  bool defined = false;
};
Operator krawczyk(const EnclosedField& f, const GraphCell& cell, const ReceiverCell& part) {
  const Slopes &q = f.q[0], &r = f.q[1];  // clang 14 captures no structured bindings
  const double a = q.s.middle(), b = q.t.middle(), c = r.s.middle(), d = r.t.middle();
  const double det = a * d - b * c;
  if (!f.regular || !f.centred || !std::isfinite(1.0 / det)) return {};
  const double P[2][2] = {{d / det, -b / det}, {-c / det, a / det}};
  const Interval du = part.u - f.q_middle[0], dv = part.v - f.q_middle[1];
  const auto row = [&](const double* p, double on_s, double on_t, double middle) {
    return Interval(middle) + p[0] * du + p[1] * dv +
           (Interval(on_s) - (p[0] * q.s + p[1] * r.s)) * f.ds +
           (Interval(on_t) - (p[0] * q.t + p[1] * r.t)) * f.dt;
  };
  return {row(P[0], 1.0, 0.0, cell.s.middle()), row(P[1], 0.0, 1.0, cell.t.middle()), true};
}

// E and ∇E over the sheet's box; false if A may vanish there (S78).
bool enclose_irradiance(const EnclosedField& f, EnclosedSheet& sheet) {
  const int sign = sign_of(f.a.v);
  if (sign == 0) return false;
  const double p = sign;
  const Interval A = p * f.a.v, middle = f.flux_middle / (p * f.a_middle);
  sheet.E = f.flux.v / A;
  Interval E_s, E_t;
  for (int round = 0; round < 2; ++round) {
    E_s = (f.flux.s - sheet.E * (p * f.a.s)) / A;
    E_t = (f.flux.t - sheet.E * (p * f.a.t)) / A;
    sheet.E = meet(sheet.E, middle + E_s * f.ds + E_t * f.dt);
  }
  const auto& [q, r] = f.q;
  // A is the determinant but for its sign.
  const Interval det = q.s * r.t - q.t * r.s;
  const Interval J = meet(det, double(sign_of(det)) * A);
  if (J.contains_zero()) return false;
  sheet.E_u = (E_s * r.t - E_t * r.s) / J;
  sheet.E_v = (E_t * q.s - E_s * q.t) / J;
  return true;
}

// Where the box is by the domain's boundaries, but for the receiver's edges.
enum class Lit { nowhere, partly, everywhere };
Lit lit(const EnclosedMap& map, const EnclosedField& f) {
  if (f.dark) return Lit::nowhere;
  Lit all = Lit::everywhere;
  for (int b = 0; b < map.domain_bounds(); ++b) {
    if (f.bounds[b].v.lo > 0.0) return Lit::nowhere;
    if (f.bounds[b].v.hi > 0.0) all = Lit::partly;
  }
  return all;
}

IntervalVec3 box_of(const EnclosedSheet& sheet) {
  IntervalVec3 box;
  box[sheet.chart.first()] = sheet.cell.s;
  box[sheet.chart.second()] = sheet.cell.t;
  box[sheet.chart.along()] = sheet.cell.z;
  return box;
}

// About where the sheet has the rectangle, from the closed form; false if it folds there.
bool guess(const ReceiverCell& part, const MirrorCells& mirror, const Cluster& cluster,
           Evaluator& evaluate, IntervalVec3& box) {
  const Vec2 middle(part.u.middle(), part.v.middle());
  const auto distance = [&](int i) {
    const ReceiverCell& image = mirror[i].image;
    return (Vec2(image.u.middle(), image.v.middle()) - middle).squaredNorm();
  };
  const int nearest = *std::min_element(cluster.cells.begin(), cluster.cells.end(),
                                        [&](int a, int b) { return distance(a) < distance(b); });
  if (!mirror[nearest].regular) return false;
  Point x;
  const IntervalVec3 own = mirror.box(nearest);
  for (int i = 0; i < 3; ++i) x[i] = own[static_cast<std::size_t>(i)].middle();
  FieldPoint f = evaluate.on_surface(x);
  if (!f.finite) return false;
  const double tolerance = kGuessedShare * std::max(part.size(), mirror[nearest].image.size());
  const auto reaches = [&](const Vec2& q) {
    auto at = preimage(evaluate, f, q, tolerance);
    if (!at) return false;
    f = std::move(*at);
    for (int i = 0; i < 3; ++i) {
      Interval& w = box[static_cast<std::size_t>(i)];
      w = hull(w, Interval(f.x[i]));
    }
    return true;
  };
  return reaches({part.u.lo, part.v.lo}) && reaches({part.u.hi, part.v.lo}) &&
         reaches({part.u.hi, part.v.hi}) && reaches({part.u.lo, part.v.hi});
}

// The sheet that is in the cluster's box: found, or found not to be, or neither. What the operator
// leaves of a box holds all preimages in it; where it is inside there is one of every place.
enum class Outcome { found, none, open };
Outcome find_sheet(const ReceiverCell& part, const MirrorCells& mirror, const Cluster& cluster,
                   Evaluator& evaluate, EnclosedSheet& sheet) {
  const EnclosedMap& map = mirror.map();
  IntervalVec3 box = cluster.box;
  if (!guess(part, mirror, cluster, evaluate, box)) return Outcome::open;
  double size = 0.0;
  for (const Interval& x : box) size = std::max(size, x.width());
  for (Interval& x : box) x = widened(x, kWiden * x.width() + kWidenAll * size);
  const auto chart = chart_over(map.map().shape(), box, sheet.cell);
  if (!chart) return Outcome::open;
  sheet.chart = *chart;
  EnclosedField f;
  for (int round = 0; round < kSheetRounds; ++round) {
    map.enclose(*chart, sheet.cell, f);
    const Operator K = krawczyk(f, sheet.cell, part);
    if (!K.defined || !K.s.bounded() || !K.t.bounded()) return Outcome::open;
    const Interval s = intersection(K.s, sheet.cell.s), t = intersection(K.t, sheet.cell.t);
    if (s.empty() || t.empty()) return Outcome::none;
    if (inside(K.s, sheet.cell.s) && inside(K.t, sheet.cell.t)) {
      sheet.alone = box_of(sheet);
      sheet.cell.s = s;
      sheet.cell.t = t;
      map.narrow(*chart, sheet.cell);
      return narrow_sheet(map, part, sheet) ? Outcome::found : Outcome::open;
    }
    if (s.width() > kNarrowShare * sheet.cell.s.width() &&
        t.width() > kNarrowShare * sheet.cell.t.width())
      return Outcome::open;
    sheet.cell.s = s;
    sheet.cell.t = t;
    if (!map.narrow(*chart, sheet.cell)) return Outcome::none;
  }
  return Outcome::open;
}

// A cluster that holds nothing may have found its neighbour's sheet. False if two could be one.
bool add(EnclosedSheet sheet, std::vector<EnclosedSheet>& sheets) {
  const IntervalVec3 box = box_of(sheet);
  for (const EnclosedSheet& other : sheets) {
    const IntervalVec3 place = box_of(other);
    if (!touch(box, place)) continue;
    return contains(other.alone, box) || contains(sheet.alone, place);
  }
  sheets.push_back(std::move(sheet));
  return true;
}

}  // namespace

// Also where x is beyond the domain, as long as the map goes on.
std::optional<FieldPoint> preimage(Evaluator& evaluate, const FieldPoint& from, const Vec2& q,
                                   double tolerance) {
  FieldPoint at = from;
  for (int i = 0; i < kSheetSteps; ++i) {
    if ((q - at.q).norm() <= tolerance) return at;
    const Vec3 step = at.pull_back(q - at.q);
    if (!step.allFinite()) return std::nullopt;
    at = evaluate.on_surface(at.x + step);
    if (!at.finite || !(at.a * from.a > 0.0)) return std::nullopt;
  }
  return std::nullopt;
}

bool narrow_sheet(const EnclosedMap& map, const ReceiverCell& part, EnclosedSheet& sheet) {
  EnclosedField f;
  for (int round = 0;; ++round) {
    map.enclose(sheet.chart, sheet.cell, f);
    if (round == kSheetRounds) break;
    const Operator K = krawczyk(f, sheet.cell, part);
    if (!K.defined) return false;
    const Interval s = intersection(K.s, sheet.cell.s), t = intersection(K.t, sheet.cell.t);
    if (s.empty() || t.empty()) return false;
    const bool worthwhile = s.width() < kNarrowShare * sheet.cell.s.width() ||
                            t.width() < kNarrowShare * sheet.cell.t.width();
    sheet.cell.s = s;
    sheet.cell.t = t;
    if (!map.narrow(sheet.chart, sheet.cell)) return false;
    sheet.cell.whole = true;
    if (!worthwhile) break;
  }
  const Lit there = lit(map, f);
  sheet.certain = there == Lit::everywhere;
  sheet.nowhere = there == Lit::nowhere;
  if (sheet.nowhere) {
    sheet.E = sheet.E_u = sheet.E_v = 0.0;
    return true;
  }
  return f.regular && enclose_irradiance(f, sheet);
}

std::optional<EnclosedSheets> sheets_over(const ReceiverCell& part, MirrorCells& mirror,
                                          std::vector<int> cells, double size,
                                          Evaluator& evaluate) {
  EnclosedSheets out;
  if (evaluate.budget().exhausted()) return std::nullopt;
  for (const double share : kImageShares) {
    std::vector<int> left;
    const bool last = share == kImageShares.back();
    cells = mirror.reaching(part, cells, share * size, evaluate.budget());
    for (const Cluster& cluster : clusters_of(mirror, cells)) {
      if (evaluate.budget().exhausted()) return std::nullopt;
      EnclosedSheet sheet;
      const Outcome outcome = find_sheet(part, mirror, cluster, evaluate, sheet);
      if (outcome == Outcome::open) {
        if (last && mirror.passage(cluster.cells) == Passage::hidden) continue;
        auto near = near_caustic(mirror, cluster);
        if (last && !near) return std::nullopt;
        if (near && (last || near->told())) {
          out.near.push_back(std::move(*near));
          continue;
        }
        left.insert(left.end(), cluster.cells.begin(), cluster.cells.end());
      } else if (outcome == Outcome::found) {
        const Passage passage = mirror.passage(cluster.cells);
        if (passage == Passage::hidden) continue;
        sheet.clear = passage == Passage::clear;
        if (!add(std::move(sheet), out.sheets)) return std::nullopt;
      }
    }
    if (left.empty()) break;
    cells = std::move(left);
  }
  std::erase_if(out.sheets, [](const EnclosedSheet& sheet) { return sheet.nowhere; });
  return out;
}

}  // namespace caustic::solver
