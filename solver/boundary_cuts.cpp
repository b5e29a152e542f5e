#include "solver/boundary_cuts.h"

#include <algorithm>
#include <cmath>

#include "geometry/root_finding.h"
#include "solver/corrector.h"

namespace caustic::solver {

using geometry::cross;

namespace {

// Newton's steps to a crossing of two images, the least sine of their angle, and the gap and the
// steps that are small enough, in widths of the receiver.
constexpr int kCrossingSteps = 20;
constexpr double kLeastSine = 1e-7;
constexpr double kCrossingGap = 1e-13;
constexpr double kCrossingStep = 1e-12;
// Polylines may miss what the curves meet by this share of a segment and the chord tolerance; a
// crossing belongs to a segment up to that share beyond its ends.
constexpr double kSegmentSlack = 0.1;
constexpr double kSegmentEnds = 1e-9;
constexpr double kBoundaryResidual = 1e-13;
// Crossings this near to a contact, in widths of the receiver, are part of it.
constexpr double kContactShare = 1e-5;
// What changes its sign is zero to this share of its values at both ends.
constexpr double kSignShare = 1e-13;
// Edges on the limit itself, to this share of the scene, do not pass it.
constexpr double kNoLimit = 1e-12;

class BoundaryCutter {
 public:
  BoundaryCutter(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves, double chord,
                 Budget& budget)
      : carrier_(carrier),
        budget_(budget),
        chord_(chord),
        curves_(curves),
        cuts_(curves.size()),
        width_(carrier.system().receiver().width()) {
    for (const BoundaryCurve& curve : curves) contacts_.push_back(contact_of(carrier, curve));
  }

  std::vector<std::vector<Cut>> run() {
    for (std::size_t c = 0; c < curves_.size() && !budget_.exhausted(); ++c) {
      if (curves_[c].on_receiver_edge()) continue;
      if (curves_[c].kind == BoundaryKind::caustic) {
        cut_at_cusps(c);
      } else {
        cut_at_contacts(c);
        if (curves_[c].edge) cut_at_limits(c);
      }
    }
    share_cuts();
    tangential_ = cuts_;
    for (std::size_t c = 0; c < curves_.size(); ++c) {
      if (curves_[c].on_receiver_edge()) cut_at_ends_of_others(c);
    }
    cut_at_crossings();
    for (auto& cuts : cuts_) {
      std::sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.at < b.at; });
    }
    return std::move(cuts_);
  }

 private:
  std::size_t segments(std::size_t c) const {
    return curves_[c].closed ? curves_[c].q.size() : curves_[c].q.size() - 1;
  }
  double slack(const Vec2& segment) const { return kSegmentSlack * segment.norm() + 2.0 * chord_; }
  void cut_at_crossings();
  void cross_segments(std::size_t c, std::size_t i, std::size_t d, std::size_t j);
  void cut_at_ends_of_others(std::size_t c);
  void cut_at_cusps(std::size_t c);
  void cut_at_contacts(std::size_t c);
  void cut_caustics_at(int field, const FieldPoint& contact);
  void cut_at_limits(std::size_t c);
  void share_cuts();
  void cut_beside(std::size_t c, const Vec2& q);
  // Next to a place where two images touch rounding makes them cross.
  bool at_contact(std::size_t c, const Vec2& q) const {
    return std::any_of(tangential_[c].begin(), tangential_[c].end(), [&](const Cut& cut) {
      return (cut.place.q - q).norm() <= kContactShare * width_;
    });
  }
  void add_cut(std::size_t c, std::size_t i, BoundaryPlace at);

  SheetCarrier& carrier_;
  Budget& budget_;
  double chord_;
  const std::vector<BoundaryCurve>& curves_;
  std::vector<std::vector<Cut>> cuts_, tangential_;
  std::vector<int> contacts_;  // of curves
  double width_;
};

// Newton's method on both curves at once: q_A + α q̇_A = q_B + β q̇_B (S52).
void BoundaryCutter::cross_segments(std::size_t c, std::size_t i, std::size_t d, std::size_t j) {
  const std::size_t in = (i + 1) % curves_[c].q.size(), jn = (j + 1) % curves_[d].q.size();
  const Vec2 &a0 = curves_[c].q[i], &a1 = curves_[c].q[in], &b0 = curves_[d].q[j],
             &b1 = curves_[d].q[jn];
  const Vec2 da = a1 - a0, db = b1 - b0;
  const double det = cross(da, db);
  if (det == 0.0) return;
  const double w = cross(b0 - a0, db) / det, v = cross(b0 - a0, da) / det;
  if (!(std::abs(w - 0.5) <= 0.5 + slack(da) / da.norm() &&
        std::abs(v - 0.5) <= 0.5 + slack(db) / db.norm()))
    return;
  auto a = settle_on(carrier_, curves_[c], on_segment(curves_[c], i, w));
  auto b = settle_on(carrier_, curves_[d], on_segment(curves_[d], j, v));
  for (int k = 0; k < kCrossingSteps && a && b; ++k) {
    const Vec2 gap = b->q - a->q;
    Vec3 ta, tb;
    const Vec2 qa = image_tangent(carrier_, curves_[c], *a, ta),
               qb = image_tangent(carrier_, curves_[d], *b, tb);
    const double sine = cross(qa, qb);
    if (std::abs(sine) <= kLeastSine * qa.norm() * qb.norm()) return;
    const double alpha = cross(gap, qb) / sine, beta = cross(gap, qa) / sine;
    if (gap.norm() <= kCrossingGap * width_ ||
        (k > 3 && std::max(std::abs(alpha) * qa.norm(), std::abs(beta) * qb.norm()) <=
                      kCrossingStep * width_)) {
      // Within the segments, or each crossing would be found from their neighbours too.
      const double wa = da.dot(a->q - a0) / da.squaredNorm(),
                   wb = db.dot(b->q - b0) / db.squaredNorm();
      if (!(std::abs(wa - 0.5) <= 0.5 + kSegmentEnds && std::abs(wb - 0.5) <= 0.5 + kSegmentEnds))
        return;
      if (at_contact(c, a->q) || at_contact(d, a->q)) return;
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
      const double more = slack(b - a);
      all.push_back({std::min(a.x(), b.x()) - more, std::max(a.x(), b.x()) + more,
                     std::min(a.y(), b.y()) - more, std::max(a.y(), b.y()) + more, c, i});
    }
  }
  std::sort(all.begin(), all.end(), [](const Segment& s, const Segment& t) { return s.lo < t.lo; });
  for (std::size_t s = 0; s < all.size() && !budget_.exhausted(); ++s) {
    for (std::size_t t = s + 1; t < all.size() && all[t].lo <= all[s].hi; ++t) {
      const Segment &a = all[s], &b = all[t];
      if (a.top < b.bottom || b.top < a.bottom) continue;
      const bool edges = curves_[a.curve].on_receiver_edge() && curves_[b.curve].on_receiver_edge();
      const bool one_image = contacts_[a.curve] >= 0 && contacts_[a.curve] == contacts_[b.curve];
      const std::size_t apart = a.i > b.i ? a.i - b.i : b.i - a.i;
      const bool neighbours = a.curve == b.curve && (apart <= 1 || apart + 1 >= segments(a.curve));
      if (!edges && !neighbours && !one_image) cross_segments(a.curve, a.i, b.curve, b.i);
    }
  }
}

// A curve that ends on this one: on an edge of the receiver, exactly there.
void BoundaryCutter::cut_at_ends_of_others(std::size_t c) {
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

// The cusp of a caustic's image is a vertex of its trace.
void BoundaryCutter::cut_at_cusps(std::size_t c) {
  const BoundaryCurve& curve = curves_[c];
  const std::size_t n = curve.q.size();
  for (std::size_t i = 0; i < segments(c); ++i) {
    const std::size_t next = (i + 1) % n, after = (next + 1) % n;
    if (!curve.closed && next + 1 >= n) continue;
    if ((curve.q[next] - curve.q[i]).dot(curve.q[after] - curve.q[next]) < 0.0)
      add_cut(c, next == 0 ? n - 1 : i, {curve.q[next], curve.own[next]});
  }
}

// Where a boundary passes a = 0, its image touching the caustic's.
void BoundaryCutter::cut_at_contacts(std::size_t c) {
  const BoundaryCurve& curve = curves_[c];
  const std::size_t n = curve.q.size();
  for (std::size_t i = 0; i < segments(c); ++i) {
    const double a = curve.own[i].a, b = curve.own[(i + 1) % n].a;
    if (a * b >= 0.0) continue;
    const auto at = correct_at_end(carrier_.evaluator(curve.field), LevelFunction::caustic(),
                                   curve.function(carrier_.field(curve.field)),
                                   on_segment(curve, i, a / (a - b)).own.x, {kBoundaryResidual});
    if (!at) continue;
    add_cut(c, i, {at->q, *at});
    if (curve.edge) cut_caustics_at(curve.field, *at);
  }
}

// An edge of the domain ends the caustic; what hides does not, as curves are traced.
void BoundaryCutter::cut_caustics_at(int field, const FieldPoint& contact) {
  for (std::size_t c = 0; c < curves_.size(); ++c) {
    const BoundaryCurve& curve = curves_[c];
    if (curve.kind != BoundaryKind::caustic || curve.field != field) continue;
    for (std::size_t i = 0; i < segments(c); ++i) {
      const Vec3 chord = curve.own[(i + 1) % curve.q.size()].x - curve.own[i].x;
      const Vec3 way = contact.x - curve.own[i].x;
      const double w = chord.dot(way) / chord.squaredNorm();
      if (!(w >= 0.0 && w <= 1.0)) continue;
      if ((way - w * chord).norm() <= kSegmentSlack * chord.norm())
        add_cut(c, i, {contact.q, contact});
    }
  }
}

// Where one of the functions changes its sign that say where an edge ceases to be one.
void BoundaryCutter::cut_at_limits(std::size_t c) {
  const BoundaryCurve& curve = curves_[c];
  const std::size_t n = curve.q.size();
  const double nowhere = kNoLimit * carrier_.system().diameter();
  std::vector<double> before = curve.edge->limits(curve.own.front());
  for (std::size_t i = 0; i < segments(c); ++i) {
    const std::size_t next = (i + 1) % n;
    const std::vector<double> after = curve.edge->limits(curve.own[next]);
    for (std::size_t k = 0; k < after.size(); ++k) {
      if (before[k] * after[k] >= 0.0 ||
          std::max(std::abs(before[k]), std::abs(after[k])) <= nowhere)
        continue;
      std::optional<BoundaryPlace> at;
      geometry::illinois_root(
          [&](double w) {
            auto place = settle_on(carrier_, curve, on_segment(curve, i, w));
            if (place) at = std::move(place);
            return at ? curve.edge->limits(at->own)[k] : before[k];
          },
          [&](double, double value) {
            return std::abs(value) <= kSignShare * (std::abs(before[k]) + std::abs(after[k]));
          },
          0.0, 1.0, before[k], after[k]);
      if (at) add_cut(c, i, std::move(*at));
    }
    before = after;
  }
}

// Curves with one image are cut at the same places.
void BoundaryCutter::share_cuts() {
  const auto own = cuts_;
  for (std::size_t c = 0; c < curves_.size(); ++c) {
    for (std::size_t d = 0; d < curves_.size(); ++d) {
      if (d == c || contacts_[c] < 0 || contacts_[c] != contacts_[d]) continue;
      for (const Cut& cut : own[c]) cut_beside(d, cut.place.q);
    }
  }
}

// Along the curve to the place with this image.
void BoundaryCutter::cut_beside(std::size_t c, const Vec2& q) {
  const BoundaryCurve& curve = curves_[c];
  for (std::size_t i = 0; i < segments(c); ++i) {
    const Vec2 chord = curve.q[(i + 1) % curve.q.size()] - curve.q[i], way = q - curve.q[i];
    const double w = chord.dot(way) / chord.squaredNorm();
    if (!(w >= 0.0 && w <= 1.0 && (way - w * chord).norm() <= slack(chord))) continue;
    auto at = settle_on(carrier_, curve, on_segment(curve, i, w));
    for (int k = 0; k < kCrossingSteps && at; ++k) {
      const Vec2 gap = q - at->q;
      if (gap.norm() <= kSameCut * width_) return add_cut(c, i, {q, at->own});
      Vec3 t;
      const Vec2 along = image_tangent(carrier_, curve, *at, t);
      BoundaryPlace next = *at;
      next.own.x += along.dot(gap) / along.squaredNorm() * t;
      at = settle_on(carrier_, curve, next);
    }
  }
}

}  // namespace

Vec2 image_tangent(const SheetCarrier& carrier, const BoundaryCurve& curve, const BoundaryPlace& at,
                   Vec3& t) {
  if (curve.on_receiver_edge()) {
    t.setZero();
    return (curve.q.back() - curve.q.front()).normalized();
  }
  t = curve.function(carrier.field(curve.field)).tangent(at.own);
  return at.own.push_forward(t);
}

BoundaryPlace on_segment(const BoundaryCurve& curve, std::size_t i, double w) {
  const std::size_t next = (i + 1) % curve.q.size();
  BoundaryPlace at;
  at.q = (1.0 - w) * curve.q[i] + w * curve.q[next];
  if (!curve.own.empty()) {
    at.own = curve.own[i];
    at.own.x = (1.0 - w) * curve.own[i].x + w * curve.own[next].x;
  }
  return at;
}

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

std::vector<std::vector<Cut>> find_cuts(SheetCarrier& carrier,
                                        const std::vector<BoundaryCurve>& curves, double chord,
                                        Budget& budget) {
  return BoundaryCutter(carrier, curves, chord, budget).run();
}

}  // namespace caustic::solver
