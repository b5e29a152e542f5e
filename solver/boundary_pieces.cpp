#include "solver/boundary_pieces.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "solver/piece_follower.h"
#include "solver/shared_edges.h"

namespace caustic::solver {

using geometry::cross;

namespace {

// The inside of a caustic is looked for so far from it along the fold, as a share of the scene.
constexpr double kFoldStep = 1e-4;
// Sheets found this near to the piece's own, as a share of the scene, are its own; and next to a
// caustic, where a is below this share of its scale, those this near.
constexpr double kOwnSheet = 1e-6;
constexpr double kFoldSheet = 1e-2;
constexpr double kFoldShare = 1e-4;
// Sheets on both sides of a contact are found so far from it, as shares of the scene and of the way
// between two vertices; pieces this near, in chord tolerances, may have one image.
constexpr double kBesideContact = 1e-6;
constexpr double kBesideShare = 1e-3;
constexpr double kSameImage = 3.0;
// How many parts there may be of all pieces together, and what share of the largest total those on
// the two sides of a parting may differ by.
constexpr std::size_t kMostParts = 64;
constexpr double kPartedTotal = 1e-3;
// The second look at whether an edge is one is taken from so far, as a share of the scene.
constexpr double kSlit = 1e-9;

// The vertex next to half of the length, not an end; nothing if there is none between these shares
// of it, as next to a cusp, where vertices crowd.
constexpr double kMiddleFrom = 0.1;
std::optional<std::size_t> middle_of(const std::vector<BoundaryPlace>& places) {
  std::vector<double> length{0.0};
  for (std::size_t i = 1; i < places.size(); ++i)
    length.push_back(length.back() + (places[i].q - places[i - 1].q).norm());
  const double all = length.back();
  std::optional<std::size_t> best;
  for (std::size_t i = 1; i + 1 < places.size(); ++i) {
    if (length[i] < kMiddleFrom * all || length[i] > (1.0 - kMiddleFrom) * all) continue;
    if (!best || std::abs(length[i] - 0.5 * all) < std::abs(length[*best] - 0.5 * all)) best = i;
  }
  return best;
}

// The longest segment.
std::size_t longest_of(const std::vector<BoundaryPlace>& places) {
  std::size_t longest = 0;
  for (std::size_t i = 1; i + 1 < places.size(); ++i) {
    if ((places[i + 1].q - places[i].q).norm() > (places[longest + 1].q - places[longest].q).norm())
      longest = i;
  }
  return longest;
}

class PieceMaker {
 public:
  PieceMaker(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves, double chord,
             Budget& budget)
      : carrier_(carrier),
        budget_(budget),
        chord_(chord),
        curves_(curves),
        width_(carrier.system().receiver().width()) {}

  BoundaryPieces run() {
    const auto cuts = find_cuts(carrier_, curves_, chord_, budget_);
    for (std::size_t c = 0; c < curves_.size() && !budget_.exhausted(); ++c) split(c, cuts[c]);
    return std::move(result_);
  }

 private:
  BoundaryPlace place(std::size_t c, std::size_t i) const {
    const BoundaryCurve& curve = curves_[c];
    return {curve.q[i], curve.own.empty() ? FieldPoint{} : curve.own[i]};
  }
  void split(std::size_t c, const std::vector<Cut>& cuts);
  void finish(std::size_t c, bool closed, std::vector<BoundaryPlace> places);
  Opening opening_on(const BoundaryCurve& curve, const BoundaryPlace& at);
  bool inside_left(const BoundaryCurve& curve, const BoundaryPlace& a, const BoundaryPlace& b,
                   const Vec3& inside);
  bool mate_left(const BoundaryCurve& curve, const BoundaryPlace& a, const Vec2& along);
  bool ends_here(const BoundaryCurve& curve, const BoundaryVertex& v, const Branch& b) const;
  void part_sides(const BoundaryCurve& curve, const Vec2& along, BoundaryVertex& v);
  bool stood_for(const BoundaryCurve& curve, const std::vector<BoundaryPlace>& places,
                 const BoundaryPlace& at);
  BoundaryVertex begin(const BoundaryCurve& curve, const BoundaryPlace& at, const Vec2& along);
  void go_on(std::size_t c, const BoundaryVertex& end, const BoundaryVertex& middle,
             std::vector<BoundaryPlace> rest);

  SheetCarrier& carrier_;
  Budget& budget_;
  double chord_;
  const std::vector<BoundaryCurve>& curves_;
  double width_;
  BoundaryPieces result_;
  std::size_t parts_ = 0;  // of pieces that could not be followed to their ends
};

void PieceMaker::split(std::size_t c, const std::vector<Cut>& cuts) {
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

// Is the curve's own side left of a → b?
bool PieceMaker::inside_left(const BoundaryCurve& curve, const BoundaryPlace& a,
                             const BoundaryPlace& b, const Vec3& inside) {
  const Vec2 along = b.q - a.q;
  const FieldPoint& f = a.own;
  if (curve.kind != BoundaryKind::caustic) return cross(along, f.push_forward(inside)) > 0.0;
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

// And the mate's?
bool PieceMaker::mate_left(const BoundaryCurve& curve, const BoundaryPlace& a, const Vec2& along) {
  const Mate mate = mate_at(carrier_, curve, a.own);
  return cross(along, mate.sheet.at.push_forward(mate.inside)) > 0.0;
}

// Sheets that fade out and others that fade in, as where rays pass along the receiver, part a piece
// in two with the same totals. Where they differ a boundary has been missed.
void PieceMaker::go_on(std::size_t c, const BoundaryVertex& end, const BoundaryVertex& middle,
                       std::vector<BoundaryPlace> rest) {
  const std::size_t before = result_.pieces.size();
  if (++parts_ <= kMostParts && !budget_.exhausted()) finish(c, false, std::move(rest));
  const auto same = [&](double a, double b) {
    return std::abs(a - b) <= kPartedTotal * std::max({std::abs(a), std::abs(b), middle.inside});
  };
  const auto continues = [&](const BoundaryVertex& v) {
    return v.followed && (v.at.q - end.at.q).norm() <= 2.0 * kSameCut * width_ &&
           same(v.inside, end.inside) && same(v.outside, end.outside);
  };
  const bool found =
      std::any_of(result_.pieces.begin() + static_cast<std::ptrdiff_t>(before),
                  result_.pieces.end(), [&](const BoundaryPiece& piece) {
                    return continues(piece.vertices.front()) || continues(piece.vertices.back());
                  });
  result_.unresolved += !found;
}

// The curve's own sheet, or one of the fold that it is, or its mate's.
bool PieceMaker::ends_here(const BoundaryCurve& curve, const BoundaryVertex& v,
                           const Branch& b) const {
  const double diameter = carrier_.system().diameter();
  if (curve.mate >= 0 && b.field == curve.mate)
    return (b.at.x - v.companions.front().sheet.at.x).norm() <= kOwnSheet * diameter;
  if (b.field != curve.field) return false;
  const double apart = (b.at.x - v.at.own.x).norm();
  // Next to a caustic both sheets of the fold may have been found.
  const bool fold = curve.kind == BoundaryKind::caustic &&
                    std::abs(b.at.a) <= kFoldShare * b.at.scale_of_a() &&
                    apart <= kFoldSheet * diameter;
  return apart <= kOwnSheet * diameter || fold;
}

// Those of one side only end here, too (S84).
void PieceMaker::part_sides(const BoundaryCurve& curve, const Vec2& along, BoundaryVertex& v) {
  const double diameter = carrier_.system().diameter();
  const double step = std::min(kBesideContact * diameter, kBesideShare * along.norm());
  const auto beside = [&](double side) {
    Branches found = carrier_.find(v.at.q + side * step * Vec2(-along.y(), along.x()).normalized(),
                                   SheetCarrier::Look::anew);
    std::erase_if(found, [&](Branch& b) {
      auto at = carrier_.carry(b.field, b.at, v.at.q);
      if (at) b.at = std::move(*at);
      result_.unresolved += !at;
      return !at || ends_here(curve, v, b);
    });
    return found;
  };
  Branches outside = beside(-1.0);
  for (Branch& b : beside(1.0)) {
    const auto same = std::find_if(outside.begin(), outside.end(), [&](const Branch& other) {
      return other.field == b.field && (other.at.x - b.at.x).norm() <= kOwnSheet * diameter;
    });
    if (same == outside.end()) {
      v.companions.push_back({std::move(b), true});
    } else {
      outside.erase(same);
      v.others.push_back(std::move(b));
    }
  }
  for (Branch& b : outside) v.companions.push_back({std::move(b), false});
}

BoundaryVertex PieceMaker::begin(const BoundaryCurve& curve, const BoundaryPlace& at,
                                 const Vec2& along) {
  BoundaryVertex first{at, {}, {}};
  if (curve.mate >= 0)
    first.companions.push_back(
        {mate_at(carrier_, curve, at.own).sheet, mate_left(curve, at, along)});
  if (contact_of(carrier_, curve) >= 0) {
    part_sides(curve, along, first);
  } else {
    first.others = carrier_.find(at.q, SheetCarrier::Look::anew);
    std::erase_if(first.others, [&](const Branch& b) { return ends_here(curve, first, b); });
  }
  complete_totals(carrier_, curve, first);
  return first;
}

// Is the curve's own sheet a companion of a piece with the same image? It stands for this one, too.
bool PieceMaker::stood_for(const BoundaryCurve& curve, const std::vector<BoundaryPlace>& places,
                           const BoundaryPlace& at) {
  const int surface = contact_of(carrier_, curve);
  if (surface < 0) return false;
  const double near = kSameImage * chord_;
  const auto is_own = [&](const BoundaryVertex& v) {
    return std::any_of(v.companions.begin(), v.companions.end(), [&](const Companion& c) {
      if (c.sheet.field != curve.field) return false;
      const auto there = carrier_.carry(c.sheet.field, c.sheet.at, at.q);
      return there && (there->x - at.own.x).norm() <= kOwnSheet * carrier_.system().diameter();
    });
  };
  for (const BoundaryPiece& piece : result_.pieces) {
    if (contact_of(carrier_, curves_[piece.curve]) != surface) continue;
    const auto& v = piece.vertices;
    const auto apart = [&](const BoundaryVertex& a) { return (a.at.q - at.q).norm(); };
    const auto is_beside = [&](std::size_t i) {
      const Vec2 way = v[i + 1].at.q - v[i].at.q;
      const double w = std::clamp(way.dot(at.q - v[i].at.q) / way.squaredNorm(), 0.0, 1.0);
      return (v[i].at.q + w * way - at.q).norm() <= near &&
             is_own(apart(v[i]) < apart(v[i + 1]) ? v[i] : v[i + 1]);
    };
    for (std::size_t i = 0; i + 1 < v.size(); ++i) {
      if (!is_beside(i)) continue;
      const auto ends_with = [&](const Vec2& q) {
        return std::min((v.front().at.q - q).norm(), (v.back().at.q - q).norm()) <= near;
      };
      // What is longer than its deputy is left out in part.
      const bool whole = ends_with(places.front().q) && ends_with(places.back().q);
      result_.unresolved += !whole && !piece.closed;
      return true;
    }
  }
  return false;
}

// Where edges touch each other, what is hidden beyond is a slit next to the contact: a second look
// from nearer by.
Opening PieceMaker::opening_on(const BoundaryCurve& curve, const BoundaryPlace& at) {
  const Opening opening = opening_at(carrier_, curve, at.own);
  if (!opening.real || !curve.edge) return opening;
  const auto settled = settle_on(carrier_, curve, at);
  return settled ? opening_at(carrier_, curve, settled->own, kSlit) : opening;
}

// From the middle to both ends, the inside on the left.
void PieceMaker::finish(std::size_t c, bool closed, std::vector<BoundaryPlace> places) {
  const BoundaryCurve& curve = curves_[c];
  std::optional<std::size_t> found = middle_of(places);
  if (!found) {
    const std::size_t i = longest_of(places);
    BoundaryPlace between{0.5 * (places[i].q + places[i + 1].q), places[i].own};
    between.own.x = 0.5 * (places[i].own.x + places[i + 1].own.x);
    const auto at = settle_on(carrier_, curve, between);
    if (!at) {
      ++result_.unresolved;
      return;
    }
    found = i + 1;
    places.insert(places.begin() + static_cast<std::ptrdiff_t>(*found), *at);
  }
  std::size_t middle = *found;
  if (!curve.on_receiver_edge()) {
    const Opening opening = opening_on(curve, places[middle]);
    if (!opening.real) return;
    if (!inside_left(curve, places[middle], places[middle + 1], opening.inside)) {
      std::reverse(places.begin(), places.end());
      middle = places.size() - 1 - middle;
    }
  }
  const auto start = places.begin() + static_cast<std::ptrdiff_t>(middle);
  if (stood_for(curve, places, *start)) return;
  const BoundaryVertex first = begin(curve, *start, (start + 1)->q - (start - 1)->q);
  PieceFollower follower(carrier_, curve);
  FollowedPiece back = follower.follow(first, {std::make_reverse_iterator(start), places.rend()}),
                front = follower.follow(first, {start + 1, places.end()});
  result_.unresolved += back.lost + front.lost;
  BoundaryPiece piece{static_cast<int>(c), closed && back.rest.empty() && front.rest.empty(), {}};
  std::move(back.vertices.rbegin(), back.vertices.rend(), std::back_inserter(piece.vertices));
  piece.vertices.push_back(first);
  std::move(front.vertices.begin(), front.vertices.end(), std::back_inserter(piece.vertices));
  const BoundaryVertex head = piece.vertices.front(), tail = piece.vertices.back();
  result_.pieces.push_back(std::move(piece));
  if (!front.rest.empty()) go_on(c, tail, first, std::move(front.rest));
  std::reverse(back.rest.begin(), back.rest.end());
  if (!back.rest.empty()) go_on(c, head, first, std::move(back.rest));
}

}  // namespace

bool carry_beside(SheetCarrier& carrier, const BoundaryCurve& curve, Branches& others,
                  std::vector<Companion>& companions, const Vec2& to) {
  std::vector<Companion> moved = companions;
  for (std::size_t k = curve.mate >= 0; k < moved.size(); ++k) {
    auto at = carrier.carry(moved[k].sheet.field, moved[k].sheet.at, to);
    if (!at) return false;
    moved[k].sheet.at = std::move(*at);
  }
  if (!carrier.carry(others, to)) return false;
  companions.swap(moved);
  return true;
}

void place_mate(SheetCarrier& carrier, const BoundaryCurve& curve, const FieldPoint& own,
                std::vector<Companion>& companions) {
  if (curve.mate >= 0) companions.front().sheet = mate_at(carrier, curve, own).sheet;
}

void complete_totals(SheetCarrier& carrier, const BoundaryCurve& curve, BoundaryVertex& v) {
  place_mate(carrier, curve, v.at.own, v.companions);
  const double others = total_of(v.others).E;
  v.outside = curve.on_receiver_edge() ? 0.0 : others;
  if (curve.on_receiver_edge())
    v.inside = others;
  else if (curve.kind == BoundaryKind::caustic)
    v.inside = geometry::kInfinity;
  else
    v.inside = others + std::max(0.0, v.at.own.irradiance());
  for (const Companion& c : v.companions)
    (c.inside ? v.inside : v.outside) += std::max(0.0, c.sheet.at.irradiance());
}

Branches branches_on(const BoundaryCurve& curve, const BoundaryVertex& v, bool inside) {
  Branches all = v.others;
  if (inside && !curve.on_receiver_edge()) all.push_back({curve.field, v.at.own});
  for (const Companion& c : v.companions)
    if (c.inside == inside) all.push_back(c.sheet);
  return all;
}

BoundaryPieces cut_boundaries(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves,
                              double chord, Budget& budget) {
  return PieceMaker(carrier, curves, chord, budget).run();
}

}  // namespace caustic::solver
