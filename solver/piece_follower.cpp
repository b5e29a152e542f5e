#include "solver/piece_follower.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace caustic::solver {

namespace {

// Between vertices the total must be what gradients at both ends say, within this share of it.
constexpr double kTotalShare = 0.05;
constexpr int kMaxInsertions = 10;
// Totals that could be followed up to this near to the end of a piece, in widths of the receiver,
// became unbounded there.
constexpr double kFollowedEnd = 1e-4;
// Halvings on the way to the end of a sheet.
constexpr int kMaxApproaches = 60;
// Cosine of incidence beyond a silhouette that is not rounding's.
constexpr double kUnlit = 1e-9;

}  // namespace

// To where the vertex is; sheets end where they are lit no more.
bool PieceFollower::carry(BoundaryVertex& v) {
  return carry_beside(carrier_, curve_, v.others, v.companions, v.at.q) &&
         std::all_of(v.others.begin(), v.others.end(),
                     [](const Branch& b) { return b.at.cos_alpha >= -kUnlit; });
}

// The total on one side, by the cubic through both: at its end, and how far it leaves the straight
// line, which a peak in the middle shows in. Of what fades in or is unbounded nothing is asked.
bool PieceFollower::varies_little(const BoundaryVertex& a, const BoundaryVertex& b,
                                  bool inside) const {
  const bool as_others = curve_.on_receiver_edge() || curve_.kind == BoundaryKind::caustic ||
                         curve_.kind == BoundaryKind::silhouette ||
                         curve_.kind == BoundaryKind::total_internal_reflection;
  if (inside && as_others) return true;
  const Total at_a = total_of(branches_on(curve_, a, inside)),
              at_b = total_of(branches_on(curve_, b, inside));
  const Vec2 way = b.at.q - a.at.q;
  const double off = at_b.E - at_a.E - 0.5 * (at_a.gradient + at_b.gradient).dot(way),
               bulge = 0.125 * (at_a.gradient - at_b.gradient).dot(way);
  return !(std::max(std::abs(off), std::abs(bulge)) > kTotalShare * at_b.E);
}

// Vertices after `from` up to `to`, more where the total varies strongly. False where the sheets
// cannot be carried further.
bool PieceFollower::reach(const BoundaryVertex& from, const BoundaryPlace& to, int depth,
                          std::vector<BoundaryVertex>& out) {
  BoundaryVertex next{to, from.others, from.companions};
  const bool carried = carry(next);
  bool smooth = false;
  if (carried) {
    complete_totals(carrier_, curve_, next);
    smooth = varies_little(from, next, false) && varies_little(from, next, true);
  }
  if (!smooth && depth < kMaxInsertions) {
    BoundaryPlace middle{0.5 * (from.at.q + to.q), to.own};
    middle.own.x = 0.5 * (from.at.own.x + to.own.x);
    const auto at = settle_on(carrier_, curve_, middle);
    if (at && (at->q - middle.q).norm() <= 0.5 * (to.q - from.at.q).norm()) {
      return reach(from, *at, depth + 1, out) &&
             reach(BoundaryVertex(out.back()), to, depth + 1, out);
    }
  }
  if (carried)
    out.push_back(std::move(next));
  else
    stuck_ = to;
  return carried;
}

// From `first` through all places. Where the totals become unbounded at the last of them it says
// so; what else cannot be reached is left.
FollowedPiece PieceFollower::follow(const BoundaryVertex& first,
                                    const std::vector<BoundaryPlace>& places) {
  FollowedPiece all;
  auto& out = all.vertices;
  for (auto to = places.begin(); to != places.end(); ++to) {
    if (reach(out.empty() ? first : BoundaryVertex(out.back()), *to, 0, out)) continue;
    const BoundaryVertex reached = out.empty() ? first : out.back();
    const bool near_end = (places.back().q - reached.at.q).norm() <= kFollowedEnd * width_;
    if (auto end = near_end ? std::nullopt : approach(reached)) {
      out.push_back(std::move(*end));
      all.rest = {stuck_};
      std::copy_if(to, places.end(), std::back_inserter(all.rest), [&](const BoundaryPlace& at) {
        return (at.q - stuck_.q).norm() > kSameCut * width_;
      });
      break;
    }
    all.lost = !near_end;
    const double outside = curve_.on_receiver_edge() ? 0.0 : geometry::kInfinity;
    out.push_back({places.back(), {}, first.companions, outside, geometry::kInfinity, false});
    break;
  }
  return all;
}

// From a vertex as near to where a sheet ends that is carried as two cuts are; so near to it will
// be what cannot be reached.
std::optional<BoundaryVertex> PieceFollower::approach(BoundaryVertex from) {
  for (int k = 0; k < kMaxApproaches; ++k) {
    if ((stuck_.q - from.at.q).norm() <= kSameCut * width_) return from;
    BoundaryPlace middle{0.5 * (from.at.q + stuck_.q), stuck_.own};
    middle.own.x = 0.5 * (from.at.own.x + stuck_.own.x);
    const auto at = settle_on(carrier_, curve_, middle);
    if (!at) break;
    BoundaryVertex next{*at, from.others, from.companions};
    if (carry(next)) {
      complete_totals(carrier_, curve_, next);
      from = std::move(next);
    } else {
      stuck_ = *at;
    }
  }
  return std::nullopt;
}

}  // namespace caustic::solver
