#include "solver/boundary_pieces.h"

#include <algorithm>
#include <cmath>

#include "solver/corrector.h"

namespace caustic::solver {

namespace {

// Newton's steps to a crossing of two images, and the least sine of their angle.
constexpr int kCrossingSteps = 20;
constexpr double kLeastSine = 1e-7;
// Cuts nearer than this share of the receiver's width are one.
constexpr double kSameCut = 1e-9;
// Between vertices the total must be what gradients at both ends say, within this share of it.
constexpr double kTotalShare = 0.05;
constexpr int kMaxInsertions = 10;
constexpr double kBoundaryResidual = 1e-13;
// The inside of a caustic is looked for so far from it along the fold, as a share of the scene.
constexpr double kFoldStep = 1e-4;

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

// Along a curve: vertex index and share of the way to the next.
struct Cut {
  double at;
  BoundaryPlace place;
};

class BoundaryCutter {
 public:
  BoundaryCutter(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves, Budget& budget)
      : carrier_(carrier),
        budget_(budget),
        curves_(curves),
        cuts_(curves.size()),
        width_(carrier.system().receiver().width()) {}

  BoundaryPieces run() {
    cut_at_crossings();
    for (std::size_t c = 0; c < curves_.size() && !budget_.exhausted(); ++c) {
      cut_at_ends_of_others(c);
      cut_at_folds(c);
      split(c);
    }
    return std::move(result_);
  }

 private:
  const BoundaryPlace place(std::size_t c, std::size_t i) const {
    const BoundaryCurve& curve = curves_[c];
    return {curve.q[i], curve.own.empty() ? FieldPoint{} : curve.own[i]};
  }
  std::size_t segments(std::size_t c) const {
    return curves_[c].closed ? curves_[c].q.size() : curves_[c].q.size() - 1;
  }
  BoundaryPlace between(std::size_t c, std::size_t i, double w) const;
  Vec2 image_tangent(std::size_t c, const BoundaryPlace& at, Vec3& t) const;
  void cut_at_crossings();
  void cut_at_ends_of_others(std::size_t c);
  void cut_at_folds(std::size_t c);
  void cross_segments(std::size_t c, std::size_t i, std::size_t d, std::size_t j);
  void add_cut(std::size_t c, std::size_t i, BoundaryPlace at);
  void split(std::size_t c);
  void finish(std::size_t c, bool closed, std::vector<BoundaryPlace> places);
  bool inside_left(std::size_t c, const BoundaryPlace& a, const BoundaryPlace& b);
  bool follow(std::size_t c, const BoundaryVertex& from, const BoundaryPlace& to, int depth,
              std::vector<BoundaryVertex>& out);

  SheetCarrier& carrier_;
  Budget& budget_;
  const std::vector<BoundaryCurve>& curves_;
  std::vector<std::vector<Cut>> cuts_;
  double width_;
  BoundaryPieces result_;
};

// A start for settle_on: on the chord.
BoundaryPlace BoundaryCutter::between(std::size_t c, std::size_t i, double w) const {
  const BoundaryCurve& curve = curves_[c];
  const std::size_t next = (i + 1) % curve.q.size();
  BoundaryPlace at;
  at.q = (1.0 - w) * curve.q[i] + w * curve.q[next];
  if (!curve.own.empty()) {
    at.own = curve.own[i];
    at.own.x = (1.0 - w) * curve.own[i].x + w * curve.own[next].x;
  }
  return at;
}

Vec2 BoundaryCutter::image_tangent(std::size_t c, const BoundaryPlace& at, Vec3& t) const {
  const BoundaryCurve& curve = curves_[c];
  if (curve.on_receiver_edge()) {
    t.setZero();
    return (curve.q.back() - curve.q.front()).normalized();
  }
  t = curve.function(carrier_.field(curve.field)).tangent(at.own);
  return at.own.push_forward(t);
}

// Newton's method on both curves at once: q_A + α q̇_A = q_B + β q̇_B (S52).
void BoundaryCutter::cross_segments(std::size_t c, std::size_t i, std::size_t d, std::size_t j) {
  const std::size_t in = (i + 1) % curves_[c].q.size(), jn = (j + 1) % curves_[d].q.size();
  const Vec2 &a0 = curves_[c].q[i], &a1 = curves_[c].q[in], &b0 = curves_[d].q[j],
             &b1 = curves_[d].q[jn];
  const Vec2 da = a1 - a0, db = b1 - b0;
  const double det = cross(da, db);
  if (det == 0.0) return;
  const double w = cross(b0 - a0, db) / det, v = cross(b0 - a0, da) / det;
  // Polylines may miss what the curves meet by a share of a segment.
  if (!(w >= -0.1 && w <= 1.1 && v >= -0.1 && v <= 1.1)) return;
  auto a = settle_on(carrier_, curves_[c], between(c, i, w));
  auto b = settle_on(carrier_, curves_[d], between(d, j, v));
  for (int k = 0; k < kCrossingSteps && a && b; ++k) {
    const Vec2 gap = b->q - a->q;
    Vec3 ta, tb;
    const Vec2 qa = image_tangent(c, *a, ta), qb = image_tangent(d, *b, tb);
    const double sine = cross(qa, qb);
    if (std::abs(sine) <= kLeastSine * qa.norm() * qb.norm()) return;
    const double alpha = cross(gap, qb) / sine, beta = cross(gap, qa) / sine;
    if (gap.norm() <= 1e-13 * width_ ||
        (k > 3 &&
         std::max(std::abs(alpha) * qa.norm(), std::abs(beta) * qb.norm()) <= 1e-12 * width_)) {
      // Within the segments, or each crossing would be found from their neighbours too.
      const double wa = da.dot(a->q - a0) / da.squaredNorm(),
                   wb = db.dot(b->q - b0) / db.squaredNorm();
      if (!(wa >= -1e-9 && wa <= 1.0 + 1e-9 && wb >= -1e-9 && wb <= 1.0 + 1e-9)) return;
      b->q = a->q;
      add_cut(c, i, *a);
      add_cut(d, j, *b);
      return;
    }
    BoundaryPlace next_a = *a, next_b = *b;
    next_a.q += alpha * qa;
    next_a.own.x += alpha * ta;
    next_b.q += beta * qb;
    next_b.own.x += beta * tb;
    a = settle_on(carrier_, curves_[c], next_a);
    b = settle_on(carrier_, curves_[d], next_b);
  }
}

void BoundaryCutter::add_cut(std::size_t c, std::size_t i, BoundaryPlace at) {
  const BoundaryCurve& curve = curves_[c];
  const Vec2& q0 = curve.q[i];
  const Vec2 chord = curve.q[(i + 1) % curve.q.size()] - q0;
  const double w = std::clamp(chord.dot(at.q - q0) / chord.squaredNorm(), 0.0, 1.0);
  for (const Cut& cut : cuts_[c]) {
    if ((cut.place.q - at.q).norm() <= kSameCut * width_ &&
        (curve.own.empty() || (cut.place.own.x - at.own.x).norm() <= kSameCut * width_)) {
      return;
    }
  }
  cuts_[c].push_back({double(i) + w, std::move(at)});
}

// All pairs of segments whose boxes overlap, by a sweep along u.
void BoundaryCutter::cut_at_crossings() {
  struct Segment {
    double lo, hi, bottom, top;
    std::size_t curve, i;
  };
  std::vector<Segment> all;
  for (std::size_t c = 0; c < curves_.size(); ++c) {
    for (std::size_t i = 0; i < segments(c); ++i) {
      const Vec2 &a = curves_[c].q[i], &b = curves_[c].q[(i + 1) % curves_[c].q.size()];
      const double slack = 0.1 * (b - a).norm();
      all.push_back({std::min(a.x(), b.x()) - slack, std::max(a.x(), b.x()) + slack,
                     std::min(a.y(), b.y()) - slack, std::max(a.y(), b.y()) + slack, c, i});
    }
  }
  std::sort(all.begin(), all.end(), [](const Segment& s, const Segment& t) { return s.lo < t.lo; });
  for (std::size_t s = 0; s < all.size() && !budget_.exhausted(); ++s) {
    for (std::size_t t = s + 1; t < all.size() && all[t].lo <= all[s].hi; ++t) {
      const Segment &a = all[s], &b = all[t];
      if (a.top < b.bottom || b.top < a.bottom) continue;
      const bool edges = curves_[a.curve].on_receiver_edge() && curves_[b.curve].on_receiver_edge();
      const std::size_t apart = a.i > b.i ? a.i - b.i : b.i - a.i;
      const bool neighbours = a.curve == b.curve && (apart <= 1 || apart + 1 >= segments(a.curve));
      if (!edges && !neighbours) cross_segments(a.curve, a.i, b.curve, b.i);
    }
  }
}

// A curve that ends on this one: on an edge of the receiver, exactly there.
void BoundaryCutter::cut_at_ends_of_others(std::size_t c) {
  if (!curves_[c].on_receiver_edge()) return;
  const Vec2 begin = curves_[c].q.front(), along = curves_[c].q.back() - begin;
  for (const BoundaryCurve& other : curves_) {
    if (other.closed || other.on_receiver_edge()) continue;
    for (const Vec2& end : {other.q.front(), other.q.back()}) {
      if (std::abs(cross(end - begin, along)) > kSameCut * width_ * along.norm()) continue;
      const double w = along.dot(end - begin) / along.squaredNorm();
      if (!(w > 0.0 && w < 1.0)) continue;
      const auto i = std::min(static_cast<std::size_t>(w * double(segments(c))), segments(c) - 1);
      add_cut(c, i, {end, {}});
    }
  }
}

// Where a boundary passes the caustic, its image touching that; where a caustic's image turns back.
void BoundaryCutter::cut_at_folds(std::size_t c) {
  const BoundaryCurve& curve = curves_[c];
  if (curve.on_receiver_edge()) return;
  const FamilyField& field = carrier_.field(curve.field);
  const std::size_t n = curve.q.size();
  for (std::size_t i = 0; i < segments(c); ++i) {
    const std::size_t next = (i + 1) % n;
    if (curve.kind == BoundaryKind::caustic) {
      // The cusp is a vertex of the trace.
      const std::size_t after = (next + 1) % n;
      if (!curve.closed && next + 1 >= n) continue;
      if ((curve.q[next] - curve.q[i]).dot(curve.q[after] - curve.q[next]) < 0.0)
        add_cut(c, next == 0 ? n - 1 : i, place(c, next));
      continue;
    }
    if (curve.own[i].a * curve.own[next].a >= 0.0) continue;
    const double w = curve.own[i].a / (curve.own[i].a - curve.own[next].a);
    const auto at =
        correct_at_end(carrier_.evaluator(curve.field), LevelFunction::caustic(), field.domain,
                       curve.boundary, between(c, i, w).own.x, {kBoundaryResidual});
    if (at) add_cut(c, i, {at->q, *at});
  }
}

void BoundaryCutter::split(std::size_t c) {
  auto& cuts = cuts_[c];
  std::sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.at < b.at; });
  const std::size_t n = curves_[c].q.size();
  const auto places_from = [&](double begin, double end, std::vector<BoundaryPlace>& out) {
    for (auto i = static_cast<std::size_t>(std::floor(begin)) + 1; double(i) < end; ++i) {
      const Vec2& q = curves_[c].q[i % n];
      if (!out.empty() && (q - out.back().q).norm() <= kSameCut * width_) continue;
      out.push_back(place(c, i % n));
    }
  };
  if (cuts.empty() && curves_[c].closed) {
    std::vector<BoundaryPlace> all;
    for (std::size_t i = 0; i <= n; ++i) all.push_back(place(c, i % n));
    return finish(c, true, std::move(all));
  }
  const auto piece = [&](const BoundaryPlace& from, double begin, const BoundaryPlace& to,
                         double end) {
    std::vector<BoundaryPlace> places{from};
    places_from(begin, end, places);
    if (places.size() > 1 && (places.back().q - to.q).norm() <= kSameCut * width_)
      places.pop_back();
    places.push_back(to);
    if (places.size() == 2 && (to.q - from.q).norm() <= kSameCut * width_) return;
    finish(c, false, std::move(places));
  };
  if (curves_[c].closed) {
    for (std::size_t k = 0; k < cuts.size(); ++k) {
      const Cut &a = cuts[k], &b = cuts[(k + 1) % cuts.size()];
      piece(a.place, a.at, b.place, b.at + (k + 1 == cuts.size() ? double(n) : 0.0));
    }
    return;
  }
  Cut from{0.0, place(c, 0)};
  for (const Cut& cut : cuts) {
    piece(from.place, from.at, cut.place, cut.at);
    from = cut;
  }
  piece(from.place, from.at, place(c, n - 1), double(n - 1));
}

// The side of a → b on which the curve's own sheets are.
bool BoundaryCutter::inside_left(std::size_t c, const BoundaryPlace& a, const BoundaryPlace& b) {
  const BoundaryCurve& curve = curves_[c];
  if (curve.on_receiver_edge()) return true;
  const Vec2 along = b.q - a.q;
  const FieldPoint& f = a.own;
  if (curve.kind != BoundaryKind::caustic) {
    const Vec3 slope = curve.function(carrier_.field(curve.field)).gradient(f);
    return cross(along, f.push_forward(-slope)) > 0.0;
  }
  // Both neighbours along the null direction of M have their images on that side.
  Vec3 null = f.q_t.x() * f.e1 - f.q_s.x() * f.e2;
  if (f.q_s.x() * f.q_s.x() + f.q_t.x() * f.q_t.x() < f.q_s.y() * f.q_s.y() + f.q_t.y() * f.q_t.y())
    null = f.q_t.y() * f.e1 - f.q_s.y() * f.e2;
  const Vec3 step = kFoldStep * carrier_.system().diameter() * null.normalized();
  Evaluator& evaluate = carrier_.evaluator(curve.field);
  const FieldPoint p = evaluate.on_surface(f.x + step, f.hits.get()),
                   m = evaluate.on_surface(f.x - step, f.hits.get());
  return cross(along, p.q + m.q - 2.0 * f.q) > 0.0;
}

// Vertices after `from` up to `to`, more where the total varies strongly.
bool BoundaryCutter::follow(std::size_t c, const BoundaryVertex& from, const BoundaryPlace& to,
                            int depth, std::vector<BoundaryVertex>& out) {
  BoundaryVertex next{to, from.others};
  bool good = carrier_.carry(next.others, to.q);
  if (good) {
    complete_totals(curves_[c], next);
    const Total before = total_of(from.others), after = total_of(next.others);
    const double said = 0.5 * (before.gradient + after.gradient).dot(to.q - from.at.q);
    good = std::abs(after.E - before.E - said) <= kTotalShare * after.E;
  }
  if (!good && depth < kMaxInsertions) {
    BoundaryPlace middle{0.5 * (from.at.q + to.q), to.own};
    middle.own.x = 0.5 * (from.at.own.x + to.own.x);
    const auto at = settle_on(carrier_, curves_[c], middle);
    if (at && (at->q - middle.q).norm() <= 0.5 * (to.q - from.at.q).norm()) {
      return follow(c, from, *at, depth + 1, out) && follow(c, out.back(), to, depth + 1, out);
    }
  }
  if (next.others.size() != from.others.size() ||
      (next.inside == 0.0 && next.outside == 0.0 && !good))
    return false;
  if (!good && next.at.q != to.q) return false;
  out.push_back(std::move(next));
  return true;
}

void BoundaryCutter::finish(std::size_t c, bool closed, std::vector<BoundaryPlace> places) {
  const std::size_t middle = places.size() / 2;
  const std::size_t other = middle + 1 < places.size() ? middle + 1 : middle - 1;
  const bool ahead = other > middle;
  // A piece of two vertices has its ends for vertices: look between them.
  if (places.size() == 2) {
    BoundaryPlace start{0.5 * (places[0].q + places[1].q), places[0].own};
    start.own.x = 0.5 * (places[0].own.x + places[1].own.x);
    const auto at = settle_on(carrier_, curves_[c], start);
    if (!at) {
      ++result_.unresolved;
      return;
    }
    places.insert(places.begin() + 1, *at);
    return finish(c, closed, std::move(places));
  }
  if (inside_left(c, places[middle], places[other]) != ahead)
    std::reverse(places.begin(), places.end());
  const std::size_t start = places.size() / 2;

  BoundaryVertex first{places[start], carrier_.find(places[start].q)};
  const double reach = 1e-6 * carrier_.system().diameter();
  std::erase_if(first.others, [&](const Branch& b) {
    if (b.field != curves_[c].field) return false;
    const bool own = (b.at.x - first.at.own.x).norm() <= reach;
    // Next to a caustic both sheets of the fold may have been found.
    const bool fold = curves_[c].kind == BoundaryKind::caustic &&
                      std::abs(b.at.a) <= 1e-4 * b.at.scale_of_a() &&
                      (b.at.x - first.at.own.x).norm() <= 1e-2 * carrier_.system().diameter();
    return own || fold;
  });
  complete_totals(curves_[c], first);
  std::vector<BoundaryVertex> back, front;
  const BoundaryVertex* from = &first;
  bool all = true;
  for (std::size_t i = start; i-- > 0 && all;) {
    all = follow(c, *from, places[i], 0, back);
    if (!back.empty()) from = &back.back();
  }
  from = &first;
  bool all_front = true;
  for (std::size_t i = start + 1; i < places.size() && all_front; ++i) {
    all_front = follow(c, *from, places[i], 0, front);
    if (!front.empty()) from = &front.back();
  }
  const auto unbounded_at = [&](const BoundaryPlace& place) {
    const double outside = curves_[c].on_receiver_edge() ? 0.0 : geometry::kInfinity;
    return BoundaryVertex{place, {}, outside, geometry::kInfinity, false};
  };
  BoundaryPiece piece{static_cast<int>(c), closed, {}};
  if (!all) piece.vertices.push_back(unbounded_at(places.front()));
  piece.vertices.insert(piece.vertices.end(), std::make_move_iterator(back.rbegin()),
                        std::make_move_iterator(back.rend()));
  piece.vertices.push_back(std::move(first));
  piece.vertices.insert(piece.vertices.end(), std::make_move_iterator(front.begin()),
                        std::make_move_iterator(front.end()));
  if (!all_front) piece.vertices.push_back(unbounded_at(places.back()));
  result_.pieces.push_back(std::move(piece));
}

}  // namespace

std::optional<BoundaryPlace> settle_on(SheetCarrier& carrier, const BoundaryCurve& curve,
                                       const BoundaryPlace& near) {
  if (curve.on_receiver_edge()) {
    const Vec2 begin = curve.q.front(), along = (curve.q.back() - begin).normalized();
    return BoundaryPlace{begin + along * along.dot(near.q - begin), near.own};
  }
  const auto at =
      correct(carrier.evaluator(curve.field), curve.function(carrier.field(curve.field)),
              near.own.x, {kBoundaryResidual}, near.own.hits.get());
  if (!at) return std::nullopt;
  return BoundaryPlace{at->q, *at};
}

void complete_totals(const BoundaryCurve& curve, BoundaryVertex& v) {
  const double others = total_of(v.others).E;
  v.outside = curve.on_receiver_edge() ? 0.0 : others;
  if (curve.on_receiver_edge())
    v.inside = others;
  else if (curve.kind == BoundaryKind::caustic)
    v.inside = geometry::kInfinity;
  else
    v.inside = others + std::max(0.0, v.at.own.irradiance());
}

BoundaryPieces cut_boundaries(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves,
                              Budget& budget) {
  return BoundaryCutter(carrier, curves, budget).run();
}

}  // namespace caustic::solver
