#include "solver/shared_edges.h"

#include <algorithm>

#include "solver/boundary_cuts.h"

namespace caustic::solver {

namespace {

// Of a boundary so many places are looked at.
constexpr std::size_t kPlacesOfBoundary = 4;
// A place is on an edge, and a mate's place that of a boundary, to this share of the scene.
constexpr double kSharedPlace = 1e-6;
// Polylines of one curve are this many chord tolerances apart at most.
constexpr double kSharedChords = 3.0;
// Next to the end of a segment is at this share of it.
constexpr double kBesideEnd = 0.02;

// The hop by which the mate's family has more than the edge's own.
Hops with_hop(const Hops& hops, int at, const Hop& hop) {
  Hops more = hops;
  more.insert(more.begin() + at, hop);
  return more;
}

int field_of(SheetCarrier& carrier, const Hops& hops) {
  for (int i = 0; i < carrier.field_count(); ++i) {
    if (carrier.field(i).piece.hops == hops) return i;
  }
  return -1;
}

// Where the path of a sheet that begins with no more than a touch goes on to: the first surface of
// the family without that hop, its first, or else that of both.
Point place_without_hop(const ForwardMap& map, int hop, const FieldPoint& f) {
  if (hop > 0) return f.x;
  return map.hop_count() == 1 ? map.receiver().point(f.q) : f.hits[1].y;
}

double distance_to_image(const BoundaryCurve& curve, const Vec2& q) {
  double least = geometry::kInfinity;
  const std::size_t n = curve.q.size();
  for (std::size_t i = 0; i + (curve.closed ? 0 : 1) < n; ++i) {
    const Vec2 way = curve.q[(i + 1) % n] - curve.q[i], to = q - curve.q[i];
    const double w = std::clamp(way.dot(to) / way.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (to - w * way).norm());
  }
  return least;
}

// Does the edge stand for this place of a boundary of its mate?
bool stands_for(SheetCarrier& carrier, const BoundaryCurve& edge, const FieldPoint& of_mate,
                double chord) {
  const double near = kSharedPlace * carrier.system().diameter();
  if (distance_to_image(edge, of_mate.q) > kSharedChords * chord + near) return false;
  const Point place =
      place_without_hop(carrier.field(edge.mate).map, edge.edge->hiding().segment, of_mate);
  const FieldPoint own = carrier.evaluator(edge.field).on_surface(place);
  return std::abs(edge.edge->value(own)) <= near &&
         (mate_at(carrier, edge, own).sheet.at.x - of_mate.x).norm() <= near;
}

// Appends what of a boundary no edge stands for.
void keep_rest(SheetCarrier& carrier, const BoundaryCurve& curve,
               const std::vector<BoundaryCurve>& edges, double chord,
               std::vector<BoundaryCurve>& out) {
  const std::size_t n = curve.own.size(), segments = curve.closed ? n : n - 1;
  // A curve may end on an edge, so what is next to a vertex counts, too; and where an edge ceases
  // to be one, so does what it stands for.
  std::vector<char> shared(segments, 0);
  for (std::size_t i = 0; i < segments; ++i) {
    const auto shares = [&](const BoundaryCurve& edge, const FieldPoint& end, double beside) {
      if (edge.mate != curve.field || !stands_for(carrier, edge, end, chord)) return false;
      const auto next = settle_on(carrier, curve, on_segment(curve, i, beside));
      return next && stands_for(carrier, edge, next->own, chord);
    };
    shared[i] = std::any_of(edges.begin(), edges.end(), [&](const BoundaryCurve& edge) {
      return shares(edge, curve.own[i], kBesideEnd) ||
             shares(edge, curve.own[(i + 1) % n], 1.0 - kBesideEnd);
    });
  }
  const auto first = std::find(shared.begin(), shared.end(), 1);
  if (first == shared.end()) return out.push_back(curve);
  // Once round a closed curve from a segment that is taken out.
  const std::size_t begin = curve.closed ? static_cast<std::size_t>(first - shared.begin()) : 0;
  BoundaryCurve run{curve.kind, curve.field, curve.boundary, false, {}, {}, nullptr};
  const auto take = [&](std::size_t i) {
    run.q.push_back(curve.q[i]);
    run.own.push_back(curve.own[i]);
  };
  for (std::size_t k = begin; k < begin + segments; ++k) {
    if (shared[k % n]) continue;
    if (k == begin || shared[(k - 1) % n]) take(k % n);
    take((k + 1) % n);
    if (k + 1 < begin + segments && !shared[(k + 1) % n]) continue;
    out.push_back(run);
    run.q.clear();
    run.own.clear();
  }
}

}  // namespace

int mate_along(SheetCarrier& carrier, const BoundaryCurve& curve) {
  if (!curve.edge) return -1;
  const Hiding& hiding = curve.edge->hiding();
  const Hops& hops = carrier.field(curve.field).piece.hops;
  const Optics& optics = carrier.system().surfaces()[hiding.surface].optics;
  // A mirror that is touched turns nothing; nor does anything whose light arrives as it leaves.
  const bool touched = hiding.kind == Hiding::Kind::touch && optics.kind == Optics::Kind::mirror;
  const bool on_receiver = hiding.kind == Hiding::Kind::point &&
                           hiding.point == static_cast<int>(hops.size()) + 1 &&
                           optics.passes_light_on();
  if (!touched && !on_receiver) return -1;
  const int side = curve.edge->side(curve.own[curve.own.size() / 2]);
  return field_of(carrier, with_hop(hops, hiding.segment, {hiding.surface, side}));
}

Mate mate_at(SheetCarrier& carrier, const BoundaryCurve& curve, const FieldPoint& own) {
  const Hiding& hiding = curve.edge->hiding();
  const Point& x = hiding.segment == 0 ? curve.edge->place(own) : own.x;
  Mate mate{{curve.mate, carrier.evaluator(curve.mate).on_surface(x)}, {}};
  const Domain& domain = carrier.field(curve.mate).domain;
  const FieldPoint& f = mate.sheet.at;
  const int boundary = domain.silhouette() + (hiding.kind == Hiding::Kind::point ? 1 : 0);
  mate.inside = -domain.gradient(boundary, f);
  return mate;
}

std::vector<Point> places_by_mates(SheetCarrier& carrier, int field,
                                   const std::vector<BoundaryCurve>& curves) {
  std::vector<Point> places;
  const Hops& hops = carrier.field(field).piece.hops;
  for (const BoundaryCurve& curve : curves) {
    if (curve.boundary < 0) continue;
    const FamilyField& mate = carrier.field(curve.field);
    const Hops& more = mate.piece.hops;
    if (more.size() != hops.size() + 1) continue;
    const bool silhouette = curve.boundary == mate.domain.silhouette();
    const int hop = silhouette ? 0 : static_cast<int>(hops.size());
    if (with_hop(hops, hop, more[hop]) != more) continue;
    const std::size_t step = curve.own.size() / (kPlacesOfBoundary + 1) + 1;
    for (std::size_t i = step; i < curve.own.size(); i += step)
      places.push_back(place_without_hop(mate.map, hop, curve.own[i]));
  }
  return places;
}

void merge_shared_edges(SheetCarrier& carrier, std::vector<BoundaryCurve>& curves, double chord) {
  std::vector<BoundaryCurve> edges, merged;
  for (BoundaryCurve& curve : curves) {
    curve.mate = mate_along(carrier, curve);
    if (curve.mate >= 0) edges.push_back(curve);
  }
  for (BoundaryCurve& curve : curves) {
    if (curve.boundary < 0)
      merged.push_back(std::move(curve));
    else
      keep_rest(carrier, curve, edges, chord, merged);
  }
  curves = std::move(merged);
}

}  // namespace caustic::solver
