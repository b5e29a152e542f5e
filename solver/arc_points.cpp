#include "solver/arc_points.h"

#include <algorithm>
#include <cmath>

#include "solver/shared_edges.h"

namespace caustic::solver {

namespace {

constexpr int kMaxPointSteps = 12;
// Newton's step that need not be taken any more, in chords, and the largest distance from the
// chord.
constexpr double kLastArcStep = 1e-12;
// A step below this many chords that is not much shorter than the one before is rounding.
constexpr double kRoundingArcStep = 1e-3;
constexpr double kFurthestFromChord = 2.0;
// A place on a boundary is where its chord's share says to this, or after so many steps.
constexpr double kShareResidual = 1e-14;
constexpr int kMaxPlaceSteps = 5;
constexpr int kMaxCarryHalvings = 6;
// A sheet whose a falls to this share between two vertices ends in a fold at the second one.
constexpr double kFoldedShare = 0.1;
// Roundings of E itself.
constexpr double kIrradianceRoundings = 16.0;

// Do sheets meet in a fold at `end`, as seen from its neighbour?
bool folds(const BoundaryVertex& end, const BoundaryVertex& neighbour) {
  if (!end.followed || end.others.size() != neighbour.others.size()) return true;
  for (std::size_t k = 0; k < end.others.size(); ++k) {
    if (std::abs(end.others[k].at.a) < kFoldedShare * std::abs(neighbour.others[k].at.a))
      return true;
  }
  return false;
}

Vec2 left_of(const Vec2& c) { return {-c.y(), c.x()}; }

// h′ at a vertex.
double slope_at(const ArcVertex& v, const Vec2& chord) {
  const Vec2 g = total_of(v.branches).gradient;
  return -g.dot(chord) / g.dot(left_of(chord));
}

}  // namespace

std::optional<ArcPoint> along_level(SheetCarrier& carrier, double level, const ArcVertex& a,
                                    const ArcVertex& b, double t) {
  const Vec2 chord = b.q - a.q, across = left_of(chord);
  const double ha = slope_at(a, chord), hb = slope_at(b, chord);
  double h = t * (1.0 - t) * ((1.0 - t) * ha - t * hb);
  if (!(std::abs(h) < kFurthestFromChord)) h = 0.0;
  ArcPoint at;
  at.branches = t < 0.5 ? a.branches : b.branches;
  double last = geometry::kInfinity;
  for (int i = 0; i < kMaxPointSteps; ++i) {
    const Vec2 q = a.q + t * chord + h * across;
    // What is left may be too short a way to be told from rounding.
    const bool there = carrier.carry(at.branches, q);
    if (!there && !(last < kRoundingArcStep)) return std::nullopt;
    if (there) at.q = q;
    const Total total = total_of(at.branches);
    const double slope = total.gradient.dot(across), step = (level - total.E) / slope;
    if (!std::isfinite(step) || std::abs(h + step) > kFurthestFromChord) return std::nullopt;
    const bool all_rounding = last < kRoundingArcStep && std::abs(step) > 0.5 * last;
    if (!there || all_rounding || std::abs(step) <= kLastArcStep) {
      at.dq = chord - (total.gradient.dot(chord) / slope) * across;
      at.off = std::abs(step) * across.norm();
      return at;
    }
    last = std::abs(step);
    h += step;
  }
  return std::nullopt;
}

namespace {

// Points of one segment of a boundary by their chord's share, without what is carried there.
class BoundarySegment {
 public:
  BoundarySegment(SheetCarrier& carrier, const BoundaryCurve& curve, const BoundaryVertex& a,
                  const BoundaryVertex& b)
      : carrier_(carrier), curve_(curve), a_(a), b_(b) {}

  std::optional<ArcPoint> at(double w) const {
    ArcPoint at;
    if (curve_.on_receiver_edge()) {
      at.dq = b_.at.q - a_.at.q;
      at.q = a_.at.q + w * at.dq;
      return at;
    }
    const Vec3 chord = b_.at.own.x - a_.at.own.x;
    const double length2 = chord.squaredNorm();
    BoundaryPlace near = (w < 0.5 ? a_ : b_).at;
    near.own.x = a_.at.own.x + w * chord;
    const LevelFunction function = curve_.function(carrier_.field(curve_.field));
    for (int i = 0; i < kMaxPlaceSteps; ++i) {
      const auto place = settle_on(carrier_, curve_, near);
      if (!place) return std::nullopt;
      const Vec3 tangent = function.tangent(place->own);
      const double along = tangent.dot(chord);
      const double miss = w * length2 - chord.dot(place->own.x - a_.at.own.x);
      at.own = place->own;
      at.q = place->q;
      at.dx = (length2 / along) * tangent;
      if (!at.dx.allFinite()) return std::nullopt;
      if (std::abs(miss) <= kShareResidual * length2) break;
      near = *place;
      near.own.x += (miss / along) * tangent;
    }
    at.dq = at.own->push_forward(at.dx);
    return at;
  }

  /// Carries along the segment, in halves where one step is too long; false if that is not enough.
  bool carry(ArcPoint& moved, double from, double to, int depth = 0) const {
    const auto end = at(to);
    if (!end) return false;
    if (carry_beside(carrier_, curve_, moved.branches, moved.companions, end->q)) return true;
    if (depth == kMaxCarryHalvings) return false;
    const double middle = 0.5 * (from + to);
    return carry(moved, from, middle, depth + 1) && carry(moved, middle, to, depth + 1);
  }

 private:
  SheetCarrier& carrier_;
  const BoundaryCurve& curve_;
  const BoundaryVertex &a_, &b_;
};

}  // namespace

std::optional<ArcPoint> along_boundary(SheetCarrier& carrier, const BoundaryCurve& curve,
                                       const BoundaryVertex& a, const BoundaryVertex& b, double t) {
  const bool a_folds = b.followed && folds(a, b), b_folds = a.followed && folds(b, a);
  const BoundarySegment segment(carrier, curve, a, b);
  const double w = a_folds ? t * t : b_folds ? t * (2.0 - t) : t;
  const double speed = a_folds ? 2.0 * t : b_folds ? 2.0 * (1.0 - t) : 1.0;
  auto at = segment.at(w);
  if (!at) return std::nullopt;
  const bool from_a = b_folds || (!a_folds && w < 0.5);
  at->branches = (from_a ? a : b).others;
  at->companions = (from_a ? a : b).companions;
  // Towards a fold half the distance that is left at a time.
  double place = from_a ? 0.0 : 1.0;
  if (a_folds || b_folds) {
    const double fold = from_a ? 1.0 : 0.0;
    for (double next = 0.5 * (place + fold); std::abs(next - fold) > std::abs(w - fold);
         next = 0.5 * (place + fold)) {
      if (!segment.carry(*at, place, next)) return std::nullopt;
      place = next;
    }
  }
  if (!segment.carry(*at, place, w)) return std::nullopt;
  if (curve.mate >= 0) place_mate(carrier, curve, *at->own, at->companions);
  at->dq *= speed;
  at->dx *= speed;
  return at;
}

double rounding_of_total(const SheetCarrier& carrier, const Branches& branches) {
  double sum = 0.0;
  for (const Branch& b : branches) {
    const FieldPoint& f = b.at;
    const double E = f.irradiance();
    const Vec3 slope = (f.grad_flux - std::copysign(E, f.a) * f.grad_a) / std::abs(f.a);
    sum += slope.norm() * carrier.field(b.field).map.rounding(f.x) +
           kIrradianceRoundings * geometry::kEpsilon * E;
  }
  return sum;
}

}  // namespace caustic::solver
