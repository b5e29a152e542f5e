#include "solver/boundary_curves.h"

#include <algorithm>
#include <cmath>

#include "solver/contour_task.h"

namespace caustic::solver {

namespace {

// Vertices along an edge of the receiver, on which totals are sampled.
constexpr int kEdgeVertices = 64;

// A chart's rim is on a boundary if it is so many roundings from it.
constexpr double kRimRoundings = 100.0;

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
    case Ending::node: break;
  }
  return BoundaryKind::none;
}

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

BoundaryCurve curve_of(SheetCarrier& carrier, int field, BoundaryKind kind, int boundary,
                       const Trace& trace) {
  BoundaryCurve curve{kind, field, boundary, trace.closed, {}, {}};
  for (std::size_t i = 0; i < trace.vertices.size(); ++i) {
    const Hit* near = trace.hits.empty() ? nullptr : trace.hits[i].get();
    curve.own.push_back(carrier.evaluator(field)(trace.vertices[i].x, near));
    curve.q.push_back(curve.own.back().q);
  }
  return curve;
}

// Two boundaries may coincide, such as the rim of an aperture in the receiver's plane with that
// plane.
bool already_traced(const FamilyField& field, const BoundaryCurve& curve) {
  for (int b = 0; b < curve.boundary; ++b) {
    const bool on_it = std::all_of(curve.own.begin(), curve.own.end(), [&](const FieldPoint& f) {
      return std::abs(field.domain.value(b, f)) <= kRimRoundings * field.map.rounding(f.x);
    });
    if (on_it) return true;
  }
  return false;
}

}  // namespace

std::vector<BoundaryCurve> trace_boundaries(SheetCarrier& carrier, Budget& budget, double chord,
                                            double residual) {
  std::vector<BoundaryCurve> curves;
  for (int i = 0; i < carrier.field_count(); ++i) {
    const FamilyField& field = carrier.field(i);
    const auto trace = [&](LevelFunction level, BoundaryKind kind, std::vector<Seed> seeds) {
      ContourTask task{&field, level, -1.0, std::move(seeds), false, {}, 0};
      run(task, budget, chord, residual);
      for (const Trace& t : task.traces) {
        BoundaryCurve curve = curve_of(carrier, i, kind, level.boundary, t);
        if (!already_traced(field, curve)) curves.push_back(std::move(curve));
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
  const Vec2 half = carrier.system().receiver().half;
  const Vec2 corners[4] = {
      {-half.x(), -half.y()}, {half.x(), -half.y()}, half, {-half.x(), half.y()}};
  for (int k = 0; k < 4; ++k) {
    BoundaryCurve edge{BoundaryKind::receiver, -1, -1, false, {}, {}};
    for (int j = 0; j <= kEdgeVertices; ++j) {
      const double w = j / double(kEdgeVertices);
      edge.q.push_back((1.0 - w) * corners[k] + w * corners[(k + 1) % 4]);
    }
    curves.push_back(std::move(edge));
  }
  return curves;
}

}  // namespace caustic::solver
