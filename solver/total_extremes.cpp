#include "solver/total_extremes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "geometry/root_finding.h"
#include "solver/critical_points.h"

namespace caustic::solver {

namespace {

constexpr int kExtremeCells = 24;  // a side
// Steps towards a critical point: the longest, in widths of the receiver; how many, and how often
// each is halved. They end when the next would gain less than this share.
constexpr double kLongestClimb = 0.02;
constexpr int kMaxClimbs = 60;
constexpr int kMaxShorter = 20;
constexpr double kLastGain = 1e-14;
// Totals that differ by no more than this share are of the same sheets.
constexpr double kSameTotal = 1e-7;
// Curvatures below this share of the other one's, or that would change E by less than this share
// over the receiver, are rounding of the differences.
constexpr double kNoCurvature = 1e-6;
constexpr double kEvenShare = 1e-6;
// Distance from a boundary, in widths, at which darkness is looked for first, and how often nearer.
constexpr double kIntoTheDark = 1e-3;
constexpr int kMaxDarkSteps = 20;
// Along a segment a derivative has vanished that is this share of those at its ends.
constexpr double kFlatSlopeShare = 1e-9;
// Derivatives along a segment are taken so near to its ends.
constexpr double kNearEnd = 1e-6;

class ExtremeFinder {
 public:
  ExtremeFinder(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves)
      : carrier_(carrier), curves_(curves), receiver_(carrier.system().receiver()) {
    out_.min.E.value = geometry::kInfinity;
    out_.max.E.value = -geometry::kInfinity;
  }

  TotalExtremes run(const std::vector<BoundaryPiece>& pieces) {
    for (const BoundaryPiece& piece : pieces) look_along(piece);
    look_inside();
    return out_;
  }

 private:
  struct Start {
    Vec2 q;
    Branches branches;
    double E;
  };
  // A side of a boundary vertex that belongs to the receiver and has a bounded total.
  struct Side {
    bool inside;
    bool counts(const BoundaryCurve& curve) const {
      return inside ? curve.kind != BoundaryKind::caustic : !curve.on_receiver_edge();
    }
    double total(const BoundaryVertex& v) const { return inside ? v.inside : v.outside; }
  };

  void take(const Vec2& q, double E, double error);
  void dark_at(const Vec2& q) {
    if (out_.min.E.value > 0.0) out_.min = {{0.0, 0.0}, q, false};
  }
  void look_along(const BoundaryPiece& piece);
  void darkness_beside(const BoundaryCurve& curve, const BoundaryPiece& piece);
  void look_between(const BoundaryCurve& curve, const Side& side, const BoundaryVertex& a,
                    const BoundaryVertex& b);
  void look_inside();
  void climb(const Start& start, double sign);

  SheetCarrier& carrier_;
  const std::vector<BoundaryCurve>& curves_;
  const geometry::ReceiverFrame& receiver_;
  TotalExtremes out_;
};

void ExtremeFinder::take(const Vec2& q, double E, double error) {
  E = std::max(E, 0.0);  // rounding, next to silhouettes
  if (E < out_.min.E.value) out_.min = {{E, error}, q, false};
  if (E > out_.max.E.value && !out_.max.unbounded) out_.max = {{E, error}, q, false};
}

void ExtremeFinder::look_along(const BoundaryPiece& piece) {
  const BoundaryCurve& curve = curves_[piece.curve];
  const auto& v = piece.vertices;
  if (curve.kind == BoundaryKind::caustic && !out_.max.unbounded)
    out_.max = {{0.0, 0.0}, v[v.size() / 2].at.q, true};
  darkness_beside(curve, piece);
  for (const Side side : {Side{false}, Side{true}}) {
    if (!side.counts(curve)) continue;
    for (std::size_t i = 0; i < v.size(); ++i) {
      if (!v[i].followed || !std::isfinite(side.total(v[i]))) continue;
      const Branches branches = branches_on(curve, v[i], side.inside);
      take(v[i].at.q, side.total(v[i]), rounding_of_total(carrier_, branches));
    }
    // An extreme lies next to a vertex that is one among its neighbours.
    for (std::size_t i = 0; i + 1 < v.size(); ++i) {
      const auto total = [&](std::size_t k) { return side.total(v[k]); };
      const bool at_begin = i > 0 && (total(i) - total(i - 1)) * (total(i + 1) - total(i)) <= 0.0;
      const bool at_end =
          i + 2 < v.size() && (total(i + 1) - total(i)) * (total(i + 2) - total(i + 1)) <= 0.0;
      const bool at_tip = i == 0 || i + 2 == v.size();
      if (at_begin || at_end || at_tip) look_between(curve, side, v[i], v[i + 1]);
    }
  }
}

// Outside of what brings light there may be none.
void ExtremeFinder::darkness_beside(const BoundaryCurve& curve, const BoundaryPiece& piece) {
  for (std::size_t i = 0; i + 1 < piece.vertices.size(); ++i) {
    const BoundaryVertex &a = piece.vertices[i], &b = piece.vertices[i + 1];
    if (!a.followed || !b.followed || !a.others.empty() || !b.others.empty()) continue;
    if (out_.min.E.value <= 0.0) return;
    const Vec2 along = (b.at.q - a.at.q).normalized(), left(-along.y(), along.x());
    const Vec2 into = curve.on_receiver_edge() ? left : Vec2(-left);
    double step = kIntoTheDark * receiver_.width();
    for (int k = 0; k < kMaxDarkSteps; ++k, step *= 0.5) {
      const Vec2 q = 0.5 * (a.at.q + b.at.q) + step * into;
      if (!receiver_.contains(q) || !carrier_.find(q).empty()) continue;
      return dark_at(q);
    }
  }
}

// A root of the derivative along the boundary.
void ExtremeFinder::look_between(const BoundaryCurve& curve, const Side& side,
                                 const BoundaryVertex& a, const BoundaryVertex& b) {
  if (!a.followed || !b.followed) return;
  ArcPoint at;
  Total there;
  const auto derivative = [&](double t) {
    auto found = along_boundary(carrier_, curve, a, b, t);
    if (!found) return std::numeric_limits<double>::quiet_NaN();
    at = std::move(*found);
    if (side.inside && !curve.on_receiver_edge()) at.branches.push_back({curve.field, *at.own});
    for (const Companion& c : at.companions)
      if (c.inside == side.inside) at.branches.push_back(c.sheet);
    there = total_of(at.branches);
    return there.gradient.dot(at.dq);
  };
  const double da = derivative(kNearEnd), db = derivative(1.0 - kNearEnd);
  if (!std::isfinite(da) || !std::isfinite(db) || (da > 0.0) == (db > 0.0)) return;
  const double last = kFlatSlopeShare * (std::abs(da) + std::abs(db));
  double slope = 0.0;
  geometry::illinois_root(
      derivative,
      [&](double, double d) {
        slope = d;
        return std::abs(d) <= last;
      },
      kNearEnd, 1.0 - kNearEnd, da, db);
  if (!std::isfinite(there.E)) return;
  // E is off by D²/2D′, and D′ is about what D changes by along the segment.
  const double curvature = std::abs(db - da);
  take(at.q, there.E,
       slope * slope / std::max(curvature, 1e-300) + rounding_of_total(carrier_, at.branches));
}

void ExtremeFinder::look_inside() {
  std::vector<Start> nodes;
  const auto start_at = [&](const Vec2& q) {
    Start start{q, carrier_.find(q), 0.0};
    start.E = total_of(start.branches).E;
    return start;
  };
  for (int j = 0; j < kExtremeCells; ++j) {
    for (int i = 0; i < kExtremeCells; ++i) {
      const Vec2 share((2.0 * i + 1.0) / kExtremeCells - 1.0,
                       (2.0 * j + 1.0) / kExtremeCells - 1.0);
      nodes.push_back(start_at(share.cwiseProduct(receiver_.half)));
      if (nodes.back().branches.empty()) dark_at(nodes.back().q);
    }
  }
  const auto among_neighbours = [&](int i, int j, double sign) {
    const double E = sign * nodes[j * kExtremeCells + i].E;
    for (int n = std::max(0, j - 1); n <= std::min(kExtremeCells - 1, j + 1); ++n) {
      for (int m = std::max(0, i - 1); m <= std::min(kExtremeCells - 1, i + 1); ++m) {
        if (sign * nodes[n * kExtremeCells + m].E > E) return false;
      }
    }
    return true;
  };
  for (int j = 0; j < kExtremeCells; ++j) {
    for (int i = 0; i < kExtremeCells; ++i) {
      for (const double sign : {-1.0, 1.0}) {
        if (among_neighbours(i, j, sign)) climb(nodes[j * kExtremeCells + i], sign);
      }
    }
  }
  for (int k = 0; k < carrier_.field_count(); ++k) {
    for (const CriticalPoint& c : carrier_.field(k).critical) {
      if (!receiver_.contains(c.field.q)) continue;
      const Start start = start_at(c.field.q);
      for (const double sign : {-1.0, 1.0}) climb(start, sign);
    }
  }
}

// Newton's method for ∇E = 0, each eigenvalue of the Hessian taken to be of the sign that climbs;
// as far as the sheets can be carried. Where it stops at a boundary, that has been looked along.
void ExtremeFinder::climb(const Start& start, double sign) {
  if (start.branches.empty() || (sign < 0.0 ? out_.min.E.value <= 0.0 : out_.max.unbounded)) return;
  const double longest = kLongestClimb * receiver_.width();
  Vec2 q = start.q;
  Branches at = start.branches;
  Total total = total_of(at);
  for (int i = 0; i < kMaxClimbs; ++i) {
    const auto H = hessian_of_total(carrier_, q, at);
    if (!H) return;
    Eigen::SelfAdjointEigenSolver<geometry::Mat2> eigen;
    eigen.computeDirect(*H);
    const Vec2 sizes = eigen.eigenvalues().cwiseAbs();
    // Along a ridge, and where E is constant, there is no curvature.
    const double least =
        kNoCurvature * sizes.maxCoeff() + kEvenShare * total.E / receiver_.half.squaredNorm();
    const Vec2 slopes = eigen.eigenvectors().transpose() * total.gradient;
    Vec2 step = sign * (eigen.eigenvectors() * slopes.cwiseQuotient(sizes.cwiseMax(least)));
    const double gain = 0.5 * std::abs(total.gradient.dot(step));
    if (gain <= kLastGain * total.E) {
      // Sheets may have begun on the way that were not carried.
      const double found = total_of(carrier_.find(q)).E;
      if (std::abs(found - total.E) <= kSameTotal * total.E)
        take(q, total.E, gain + rounding_of_total(carrier_, at));
      return;
    }
    if (step.norm() > longest) step *= longest / step.norm();
    bool moved = false;
    for (int k = 0; k < kMaxShorter && !moved; ++k, step *= 0.5) {
      Branches there = at;
      if (!receiver_.contains(q + step) || !carrier_.carry(there, q + step)) continue;
      if (!sheets_exist(carrier_, there)) continue;
      const Total next = total_of(there);
      if (sign * (next.E - total.E) < -kLastGain * total.E) continue;
      q += step;
      at.swap(there);
      total = next;
      moved = true;
    }
    if (!moved) return;
  }
}

}  // namespace

TotalExtremes find_extremes(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves,
                            const std::vector<BoundaryPiece>& pieces) {
  return ExtremeFinder(carrier, curves).run(pieces);
}

}  // namespace caustic::solver
