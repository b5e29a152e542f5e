#include "solver/boundary_curves.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "solver/contour_task.h"
#include "solver/hidden_edges.h"
#include "solver/shared_edges.h"

namespace caustic::solver {

namespace {

// Vertices along an edge of the receiver, on which totals are sampled.
constexpr int kEdgeVertices = 64;

// A chart's rim is on a boundary if it is so many roundings from it.
constexpr double kRimRoundings = 100.0;

// Places on a boundary: corners of cells that were clipped there, and of those whose chart ends
// there.
std::vector<Seed> seeds_on(const FamilyField& field, int boundary) {
  std::vector<Seed> seeds;
  for (const Cell& cell : field.exploration.cells) {
    for (const Corner& corner : cell.polygon) {
      const FieldPoint& f = field.exploration.samples[corner.sample];
      const bool at_rim =
          std::abs(field.domain.value(boundary, f)) <= kRimRoundings * field.map.rounding(f.x);
      if (corner.boundary == boundary || at_rim) seeds.push_back({0, f, cell.radius});
    }
  }
  return seeds;
}

void add_given(const std::vector<Seed>& given, int boundary, std::vector<Seed>& seeds) {
  for (const Seed& seed : given) {
    if (seed.target == boundary) seeds.push_back({0, seed.at, seed.reach});
  }
}

}  // namespace

BoundaryKind kind_of(Ending ending) {
  switch (ending) {
    case Ending::silhouette:
      return BoundaryKind::silhouette;
    case Ending::aperture:
      return BoundaryKind::aperture;
    case Ending::shadow:
      return BoundaryKind::shadow;
    case Ending::occlusion:
      return BoundaryKind::occlusion;
    case Ending::total_internal_reflection:
      return BoundaryKind::total_internal_reflection;
    case Ending::receiver_edge:
      return BoundaryKind::receiver;
    case Ending::limit:
    case Ending::node:
      break;
  }
  return BoundaryKind::none;
}

int contact_of(const SheetCarrier& carrier, const BoundaryCurve& curve) {
  if (curve.field < 0) return -1;
  const FamilyField& field = carrier.field(curve.field);
  const Hops& hops = field.piece.hops;
  if (curve.edge) {
    const Hiding& hiding = curve.edge->hiding();
    const bool at_end =
        hiding.kind == Hiding::Kind::point && hiding.point == static_cast<int>(hops.size()) + 1;
    return at_end ? hiding.surface : -1;
  }
  const bool in_plane = !hops.empty() && curve.boundary == field.domain.silhouette() + 1;
  return in_plane ? hops.back().surface : -1;
}

bool coincides_with_domain(const FamilyField& field, const BoundaryCurve& curve) {
  const int before = curve.edge ? field.domain.size() : curve.boundary;
  for (int b = 0; b < before; ++b) {
    const bool on_it = std::all_of(curve.own.begin(), curve.own.end(), [&](const FieldPoint& f) {
      return std::abs(field.domain.value(b, f)) <= kRimRoundings * field.map.rounding(f.x);
    });
    if (on_it) return true;
  }
  return false;
}

BoundaryCurves curves_along(SheetCarrier& carrier, int field, BoundaryKind kind,
                            const LevelFunction& function, std::vector<Seed> seeds, Budget& budget,
                            double chord, double residual) {
  BoundaryCurves out;
  ContourTask task{&carrier.field(field), function, -1.0, std::move(seeds), false, {}, 0};
  run(task, budget, chord, residual);
  out.unresolved += task.lost_seeds;
  for (const Trace& trace : task.traces) {
    BoundaryCurve curve{kind, field, function.boundary, trace.closed, {}, {}};
    std::size_t ended = 0;  // a path that is on the edge of ending may have ended by rounding
    for (std::size_t i = 0; i < trace.vertices.size() && !budget.out_of_time(); ++i) {
      const Hit* near = trace.hits.empty() ? nullptr : trace.hits[i].get();
      FieldPoint at = carrier.evaluator(field)(trace.vertices[i].x, near);
      if (!at.finite) {
        ++ended;
        continue;
      }
      curve.q.push_back(at.q);
      curve.own.push_back(std::move(at));
    }
    if (curve.own.size() + ended < trace.vertices.size()) break;  // out of time
    out.unresolved += trace.stalled + (ended > 0);
    if (curve.own.size() > 1) out.curves.push_back(std::move(curve));
  }
  return out;
}

// A caustic's own sheets are on both of its sides, so the place itself tells.
Opening opening_at(SheetCarrier& carrier, const BoundaryCurve& curve, const FieldPoint& at,
                   double share) {
  const FamilyField& field = carrier.field(curve.field);
  const auto visible = [&](const FieldPoint& f) {
    return !field.visibility ||
           !field.visibility->hidden(field.piece.hops, LightPath(field.map, f));
  };
  const Vec3 inside = -curve.function(field).gradient(at).normalized();
  if (curve.kind == BoundaryKind::caustic) return {visible(at), inside};
  if (curve.edge && !curve.edge->possible(at)) return {false, inside};
  const double step = share * carrier.system().diameter();
  const auto beside = [&](double side) {
    const FieldPoint f =
        carrier.evaluator(curve.field).on_surface(at.x + side * step * inside, at.hits.get());
    return f.arrives() && visible(f);
  };
  const bool ahead = beside(1.0);
  if (!curve.edge) return {ahead, inside};
  return {ahead != beside(-1.0), ahead ? inside : Vec3(-inside)};
}

BoundaryCurves trace_boundaries(SheetCarrier& carrier, Budget& budget, double chord,
                                double residual, const std::vector<std::vector<Seed>>& seeds) {
  BoundaryCurves out;
  std::vector<BoundaryCurve> of_domains;
  for (int i = 0; i < carrier.field_count(); ++i) {
    const FamilyField& field = carrier.field(i);
    const auto trace = [&](LevelFunction function, BoundaryKind kind, std::vector<Seed> found_by) {
      if (!seeds.empty()) add_given(seeds[i], function.boundary, found_by);
      BoundaryCurves found =
          curves_along(carrier, i, kind, function, std::move(found_by), budget, chord, residual);
      out.unresolved += found.unresolved;
      for (BoundaryCurve& curve : found.curves) {
        if (!coincides_with_domain(field, curve)) of_domains.push_back(std::move(curve));
      }
    };
    Exploration exploration = field.exploration;
    trace(
        LevelFunction::caustic(), BoundaryKind::caustic,
        find_seeds(carrier.evaluator(i), exploration, field.critical, {LevelFunction::caustic()}));
    for (int b = 0; b < field.domain.size(); ++b) {
      const BoundaryKind kind = kind_of(field.domain.ending(b));
      if (kind == BoundaryKind::receiver) continue;
      trace(LevelFunction::boundary_of(field.domain, b), kind, seeds_on(field, b));
    }
  }
  for (int i = 0; i < carrier.field_count(); ++i) {
    std::vector<BoundaryCurve> own;
    std::copy_if(of_domains.begin(), of_domains.end(), std::back_inserter(own),
                 [&](const BoundaryCurve& curve) { return curve.field == i; });
    if (carrier.field(i).visibility) {
      const std::vector<Point> likely = places_by_mates(carrier, i, of_domains);
      out.unresolved += add_hidden_edges(carrier, i, likely, own, budget, chord, residual);
    }
    std::move(own.begin(), own.end(), std::back_inserter(out.curves));
  }
  merge_shared_edges(carrier, out.curves, chord);
  const Vec2 half = carrier.system().receiver().half;
  const Vec2 corners[4] = {
      {-half.x(), -half.y()}, {half.x(), -half.y()}, half, {-half.x(), half.y()}};
  for (int k = 0; k < 4; ++k) {
    BoundaryCurve edge{BoundaryKind::receiver, -1, -1, false, {}, {}};
    for (int j = 0; j <= kEdgeVertices; ++j) {
      const double w = j / double(kEdgeVertices);
      edge.q.push_back((1.0 - w) * corners[k] + w * corners[(k + 1) % 4]);
    }
    out.curves.push_back(std::move(edge));
  }
  return out;
}

}  // namespace caustic::solver
