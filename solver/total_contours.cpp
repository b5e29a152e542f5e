#include "solver/total_contours.h"

#include <algorithm>
#include <cmath>

#include "solver/certify_total.h"
#include "solver/critical_points.h"
#include "solver/regions.h"
#include "solver/rings.h"
#include "solver/total_grid.h"

namespace caustic::solver {

namespace {

// Ends of arcs this near, in widths of the receiver, meet.
constexpr double kJoinShare = 1e-7;
// Of one family, this near to each other as a share of the scene.
constexpr double kSameSheetOfArc = 1e-6;

// What an arc has in the answer.
struct Drawn {
  Curve curve;
  RingArc arc;
};

// Lengths, ends and the largest residual.
void measure(Curve& curve) {
  if (!curve.closed) curve.ends = {Ending::node, Ending::node};
  auto& vertices = curve.vertices;
  double length = 0.0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (i > 0) length += (vertices[i].uv - vertices[i - 1].uv).norm();
    vertices[i].arc_length = length;
    curve.max_residual = std::max(curve.max_residual, vertices[i].residual);
  }
  if (curve.closed) length += (vertices.front().uv - vertices.back().uv).norm();
  curve.length = length;
}

class TotalTracer {
 public:
  TotalTracer(const OpticalSystem& system, const std::vector<const FamilyField*>& fields,
              double chord, double residual, Budget& budget, TotalObserver* observer,
              const TotalCertificate* certificate)
      : system_(system),
        budget_(budget),
        observer_(observer),
        certificate_(certificate),
        carrier_(system, fields, budget),
        chord_(chord),
        residual_(residual),
        curves_(trace(budget)),
        pieces_(cut_boundaries(carrier_, curves_, chord, budget)),
        grid_(carrier_) {
    result_.unresolved += pieces_.unresolved;
    for (const Region& small :
         find_regions(carrier_, curves_, pieces_.pieces, grid_.blind_below()).regions)
      grid_.look_from(small.uv_inside);
    if (observer_) observer_->boundaries(carrier_, curves_, pieces_);
  }

  void keep_boundaries() {
    for (const BoundaryPiece& piece : pieces_.pieces) take(piece);
  }

  // Critical points are sought from the middle of each region too, however small it is.
  void find_regions_and_critical_points(const TotalExtras& extras) {
    Regions found = find_regions(carrier_, curves_, pieces_.pieces);
    if (extras.critical_points) {
      std::vector<Vec2> insides;
      for (const Region& region : found.regions) insides.push_back(region.uv_inside);
      result_.critical_points = critical_points_of_total(carrier_, insides);
    }
    if (!extras.regions) return;
    result_.regions = std::move(found.regions);
    result_.unresolved += found.unresolved;
  }

  TotalContours run(const std::vector<double>& levels) {
    int rings = 0;
    for (std::size_t i = 0; i < levels.size() && !budget_.exhausted(); ++i) {
      trace(static_cast<int>(i), levels[i], rings);
    }
    return std::move(result_);
  }

 private:
  std::vector<BoundaryCurve> trace(Budget& budget) {
    BoundaryCurves found = trace_boundaries(
        carrier_, budget, chord_, residual_,
        certificate_ ? certificate_->boundaries : std::vector<std::vector<Seed>>{});
    result_.unresolved = found.unresolved;
    return std::move(found.curves);
  }
  void trace(int index, double level, int& rings);
  bool traced(const TotalSeed& seed, double level);
  void take(LevelArc arc, double level, std::vector<Drawn>& drawn);
  void cut_at_missed_edge(LevelArc& arc);
  bool lacks_sheets(const LevelArc& arc);
  void take(const JumpArc& jump, double level, std::vector<Drawn>& drawn);
  void take(Curve curve, std::vector<Drawn>& drawn);
  void take(const BoundaryPiece& piece);
  CurveVertex vertex(BoundaryKind kind, const BoundaryVertex& at);
  CurveVertex vertex(const Vec2& q, const Branches& branches);

  const OpticalSystem& system_;
  Budget& budget_;
  TotalObserver* observer_;
  const TotalCertificate* certificate_;
  SheetCarrier carrier_;
  double chord_, residual_;
  TotalContours result_;
  std::vector<BoundaryCurve> curves_;
  BoundaryPieces pieces_;
  TotalGrid grid_;
  std::vector<LevelArc> arcs_;  // of this level, while there are seeds to be struck out
};

CurveVertex TotalTracer::vertex(const Vec2& q, const Branches& branches) {
  const auto& receiver = system_.receiver();
  CurveVertex v{};
  v.uv = q;
  v.p = receiver.point(q);
  v.gradient = Vec3::Zero();
  const FieldPoint* brightest = nullptr;
  for (const Branch& b : branches) {
    if (!brightest || b.at.irradiance() > brightest->irradiance()) brightest = &b.at;
  }
  v.x = brightest ? brightest->x : v.p;
  return v;
}

// With the totals on both sides.
CurveVertex TotalTracer::vertex(BoundaryKind kind, const BoundaryVertex& at) {
  const auto bounded = [](double E) { return std::isfinite(E) ? E : -1.0; };
  CurveVertex v = vertex(at.at.q, at.others);
  if (kind != BoundaryKind::receiver) v.x = at.at.own.x;
  v.irradiance = -1.0;
  v.dark = bounded(at.outside);
  v.bright = bounded(at.inside);
  return v;
}

void TotalTracer::take(const BoundaryPiece& piece) {
  const BoundaryCurve& along = curves_[piece.curve];
  Curve curve;
  curve.kind = CurveKind::boundary;
  curve.boundary = along.kind;
  curve.family_id = along.field < 0 ? -1 : carrier_.field(along.field).piece.family;
  curve.closed = piece.closed;
  for (const BoundaryVertex& at : piece.vertices) curve.vertices.push_back(vertex(along.kind, at));
  if (piece.closed) curve.vertices.pop_back();  // the first again
  if (curve.vertices.size() < 2) return;
  measure(curve);
  result_.boundaries.push_back(std::move(curve));
}

void TotalTracer::take(Curve curve, std::vector<Drawn>& drawn) {
  curve.family_id = -1;
  measure(curve);
  std::vector<Vec2> line;
  for (const CurveVertex& v : curve.vertices) line.push_back(v.uv);
  grid_.add(line, curve.closed, chord_);
  const std::size_t n = line.size();
  RingArc arc{line.front(), line.back(), (line[1] - line[0]).normalized(),
              (line[n - 1] - line[n - 2]).normalized(), curve.closed};
  drawn.push_back({std::move(curve), arc});
}

// Between its ends an arc passes no edge: where it does, more than the tolerance, one has been
// missed, and what comes behind is no total.
void TotalTracer::cut_at_missed_edge(LevelArc& arc) {
  const auto is_there = [&](const Branch& b) {
    return carrier_.field(b.field).domain.worst(b.at).value <= chord_ &&
           !carrier_.hidden(b.field, b.at);
  };
  for (std::size_t i = 1; i + 1 < arc.vertices.size(); ++i) {
    const Branches& branches = arc.vertices[i].branches;
    if (std::all_of(branches.begin(), branches.end(), is_there)) continue;
    arc.vertices.resize(i);
    arc.closed = false;
    ++result_.unresolved;
    return;
  }
}

// And no sheet begins: in its middle all are found anew.
bool TotalTracer::lacks_sheets(const LevelArc& arc) {
  const double same = kSameSheetOfArc * system_.diameter();
  const auto lacks = [&](const ArcVertex& at) {
    const Branches found = carrier_.find(at.q);
    return std::any_of(found.begin(), found.end(), [&](const Branch& b) {
      const auto is_it = [&](const Branch& known) {
        return known.field == b.field && (known.at.x - b.at.x).norm() <= same;
      };
      return std::none_of(at.branches.begin(), at.branches.end(), is_it) &&
             !carrier_.hidden(b.field, b.at, SheetCarrier::Look::anew);
    });
  };
  const std::size_t n = arc.vertices.size();
  return n > 2 && lacks(arc.vertices[n / 2]);
}

void TotalTracer::take(LevelArc arc, double level, std::vector<Drawn>& drawn) {
  result_.unresolved += arc.stalled;
  cut_at_missed_edge(arc);
  if (arc.vertices.size() < 2) return;
  result_.unresolved += lacks_sheets(arc);
  if (observer_) observer_->level_arc(level, arc);
  Curve curve;
  curve.kind = CurveKind::isolux;
  curve.level = level;
  curve.closed = arc.closed;
  if (certificate_) arcs_.push_back(arc);
  for (const ArcVertex& at : arc.vertices) {
    CurveVertex v = vertex(at.q, at.branches);
    const Total total = total_of(at.branches);
    v.irradiance = v.dark = v.bright = total.E;
    v.residual = std::abs(total.E / level - 1.0);
    v.gradient =
        total.gradient.x() * system_.receiver().u + total.gradient.y() * system_.receiver().v;
    curve.vertices.push_back(v);
  }
  take(std::move(curve), drawn);
}

void TotalTracer::take(const JumpArc& jump, double level, std::vector<Drawn>& drawn) {
  if (jump.vertices.size() < 2) return;
  Curve curve;
  curve.kind = jump.kind == BoundaryKind::receiver ? CurveKind::receiver_edge : CurveKind::jump;
  curve.level = level;
  curve.boundary = jump.kind;
  curve.closed = jump.closed;
  for (const BoundaryVertex& at : jump.vertices) {
    CurveVertex v = vertex(jump.kind, at);
    v.irradiance = level;
    if (jump.turned) std::swap(v.dark, v.bright);
    curve.vertices.push_back(v);
  }
  if (jump.turned) std::reverse(curve.vertices.begin(), curve.vertices.end());
  take(std::move(curve), drawn);
}

// True if the seed lies on an arc that has been traced.
bool TotalTracer::traced(const TotalSeed& seed, double level) {
  return std::any_of(arcs_.begin(), arcs_.end(), [&](const LevelArc& arc) {
    return on_arc(carrier_, arc, level, seed.q, chord_);
  });
}

void TotalTracer::trace(int index, double level, int& rings) {
  const std::size_t unresolved = result_.unresolved;
  LevelOnBoundaries found =
      level_on_boundaries(carrier_, curves_, pieces_.pieces, level, residual_);
  if (observer_) observer_->level_on_boundaries(level, found);
  std::vector<TotalNode> starts, ends;
  for (TotalNode& node : found.nodes) (begins_arc(node) ? starts : ends).push_back(std::move(node));
  std::vector<Drawn> drawn;
  grid_.begin(level);
  for (const JumpArc& jump : found.jumps) take(jump, level, drawn);
  ArcTracer tracer(carrier_, {level, chord_, residual_}, budget_);
  for (const TotalNode& start : starts) {
    take(tracer.follow(start.q, start.branches, ends), level, drawn);
  }
  if (certificate_) {
    for (const TotalSeed& seed : certificate_->arcs) {
      if (seed.level != index || traced(seed, level)) continue;
      take(tracer.follow(seed.q, seed.branches, ends), level, drawn);
    }
    arcs_.clear();
  }
  const std::size_t undecided = grid_.undecided();
  while (const auto place = grid_.missing()) {
    take(tracer.follow(place->q, place->branches, ends), level, drawn);
  }
  result_.unresolved += ends.size() + grid_.undecided() - undecided;

  std::vector<RingArc> arcs;
  for (const Drawn& d : drawn) arcs.push_back(d.arc);
  const Rings joined = join_rings(arcs, kJoinShare * system_.receiver().width());
  result_.unresolved += joined.open;
  for (std::size_t k = 0; k < drawn.size(); ++k) {
    drawn[k].curve.ring_id = rings + joined.id[k];
    drawn[k].curve.ring_order = joined.order[k];
    result_.curves.push_back(std::move(drawn[k].curve));
  }
  rings += joined.id.empty() ? 0 : 1 + *std::max_element(joined.id.begin(), joined.id.end());
  if (observer_) observer_->level_traced(level, result_.unresolved - unresolved);
}

}  // namespace

std::optional<std::string> total_unsupported(const std::vector<const FamilyField*>& fields) {
  for (const FamilyField* field : fields) {
    for (const Cell& cell : field->exploration.cells) {
      for (const Corner& corner : cell.polygon) {
        if (corner.boundary == kPathEnds)
          return "the total next to grazing incidence on a later surface or total reflection";
      }
    }
  }
  return std::nullopt;
}

TotalContours trace_total(const OpticalSystem& system,
                          const std::vector<const FamilyField*>& fields,
                          const std::vector<double>& levels, double chord, double residual,
                          const TotalExtras& extras, Budget& budget, TotalObserver* observer,
                          const TotalCertificate* certificate) {
  TotalTracer tracer(system, fields, chord, residual, budget, observer, certificate);
  if (extras.boundaries) tracer.keep_boundaries();
  if (extras.critical_points || extras.regions) tracer.find_regions_and_critical_points(extras);
  return tracer.run(levels);
}

}  // namespace caustic::solver
