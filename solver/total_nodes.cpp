#include "solver/total_nodes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/root_finding.h"

namespace caustic::solver {

namespace {

// A node's place, in widths of the receiver; what rounding leaves of E₀/E − 1.
constexpr double kNodePlace = 1e-10;
constexpr double kLeastExcess = 1e-15;

class NodeFinder {
 public:
  NodeFinder(SheetCarrier& carrier, const BoundaryCurve& curve, const BoundaryPiece& piece,
             double level, double residual, LevelOnBoundaries& out)
      : carrier_(carrier),
        curve_(curve),
        piece_(piece),
        level_(level),
        residual_(residual),
        out_(out) {}

  void run() {
    const auto& v = piece_.vertices;
    for (std::size_t i = 0; i < v.size(); ++i) {
      if (i == 0) {
        state_ = {v[0].outside >= level_, (fades() ? v[0].outside : v[0].inside) >= level_};
        begin_part(v[0]);
        continue;
      }
      for (const auto& [w, side, at] : crossings(i - 1)) {
        if (part_) part_->back().vertices.push_back(at);
        for (const int node_side : {0, 1}) {
          if (node_side != side && !fades()) continue;
          add_node(at, node_side);
          state_[node_side] = !state_[node_side];
        }
        begin_part(at);
      }
      if (part_) part_->back().vertices.push_back(v[i]);
    }
    if (piece_.closed && nodes_ == 0 && part_) {
      part_->back().closed = true;
      part_->back().vertices.pop_back();
    }
  }

 private:
  struct Crossing {
    double w;
    int side;  // 0 outside, 1 inside
    BoundaryVertex at;
  };
  double total(const BoundaryVertex& v, int side) const { return side == 0 ? v.outside : v.inside; }
  // Where sheets fade in both totals are one.
  bool fades() const {
    return curve_.kind == BoundaryKind::silhouette ||
           curve_.kind == BoundaryKind::total_internal_reflection;
  }
  // A part in which one side is above the level or both are begins here, or none.
  void begin_part(const BoundaryVertex& v) {
    part_ = state_[0] && state_[1] ? &out_.within : state_[0] || state_[1] ? &out_.jumps : nullptr;
    if (part_) part_->push_back({curve_.kind, piece_.curve, false, {v}, !state_[1]});
  }

  std::vector<Crossing> crossings(std::size_t i) const {
    std::vector<Crossing> found;
    const BoundaryVertex &a = piece_.vertices[i], &b = piece_.vertices[i + 1];
    for (const int side : {0, 1}) {
      if (side == 1 && fades()) continue;
      if ((total(a, side) >= level_) == (total(b, side) >= level_)) continue;
      if (auto c = root(a, b, side)) found.push_back(std::move(*c));
    }
    if (found.size() == 2 && found[1].w < found[0].w) std::swap(found[0], found[1]);
    return found;
  }

  // The vertex at share w of the way from a to b.
  std::optional<BoundaryVertex> between(const BoundaryVertex& a, const BoundaryVertex& b,
                                        double w) const {
    const bool from_a = a.followed;
    BoundaryVertex v = from_a ? a : b;
    BoundaryPlace near = v.at;
    near.q = (1.0 - w) * a.at.q + w * b.at.q;
    near.own.x = (1.0 - w) * a.at.own.x + w * b.at.own.x;
    const auto at = settle_on(carrier_, curve_, near);
    if (!at || !carry_beside(carrier_, curve_, v.others, v.companions, at->q)) return std::nullopt;
    v.at = *at;
    complete_totals(carrier_, curve_, v);
    return v;
  }

  // 1/E is bounded, and zero where the total is not.
  std::optional<Crossing> root(const BoundaryVertex& a, const BoundaryVertex& b, int side) const {
    std::optional<BoundaryVertex> last;
    double where = 0.0;
    const auto excess = [&](double E) { return level_ / E - 1.0; };
    const auto value = [&](double w) {
      auto v = between(a, b, w);
      if (!v) return -1.0;
      last = std::move(v);
      where = w;
      return excess(total(*last, side));
    };
    // Towards an end where nothing could be followed the level may lie beyond the last good place.
    const double at_a = excess(total(a, side)), at_b = excess(total(b, side));
    // Where E hardly varies its residual does not tell the place.
    const double steepness = std::abs(at_b - at_a) / (b.at.q - a.at.q).norm();
    const double place = kNodePlace * carrier_.system().receiver().width() * steepness;
    const double small = std::min(residual_, std::max(place, kLeastExcess));
    geometry::illinois_root(
        value, [&](double, double f) { return std::abs(f) <= small; }, 0.0, 1.0, at_a, at_b);
    // If nothing could be followed up to it.
    if (!last || std::abs(excess(total(*last, side))) > kLevelNoise) return std::nullopt;
    return Crossing{where, side, std::move(*last)};
  }

  void add_node(const BoundaryVertex& at, int side) {
    ++nodes_;
    TotalNode node{at.at.q, branches_on(curve_, at, side == 1), left_normal(at)};
    if (side == 0) node.into = -node.into;
    out_.nodes.push_back(std::move(node));
  }

  // The piece runs with its inside on the left: the normal of the curve itself. A polyline's would
  // not tell on which side an arc begins that hardly leaves the boundary, as where a sheet fades in
  // steeply.
  Vec2 left_normal(const BoundaryVertex& at) const {
    std::size_t nearest = 0;
    double least = geometry::kInfinity;
    for (std::size_t i = 0; i + 1 < piece_.vertices.size(); ++i) {
      const Vec2 middle = 0.5 * (piece_.vertices[i].at.q + piece_.vertices[i + 1].at.q);
      const double d = (middle - at.at.q).norm();
      if (d < least) least = d, nearest = i;
    }
    const Vec2 chord = piece_.vertices[nearest + 1].at.q - piece_.vertices[nearest].at.q;
    Vec3 on_surface;
    Vec2 along = image_tangent(carrier_, curve_, at.at, on_surface);
    if (along.isZero()) along = chord;
    if (along.dot(chord) < 0.0) along = -along;
    return Vec2(-along.y(), along.x()).normalized();
  }

  SheetCarrier& carrier_;
  const BoundaryCurve& curve_;
  const BoundaryPiece& piece_;
  double level_, residual_;
  LevelOnBoundaries& out_;
  std::array<bool, 2> state_{};
  std::vector<JumpArc>* part_ = nullptr;  // where the part that is under way is kept
  std::size_t nodes_ = 0;
};

}  // namespace

LevelOnBoundaries level_on_boundaries(SheetCarrier& carrier,
                                      const std::vector<BoundaryCurve>& curves,
                                      const std::vector<BoundaryPiece>& pieces, double level,
                                      double residual) {
  LevelOnBoundaries out;
  for (const BoundaryPiece& piece : pieces) {
    NodeFinder(carrier, curves[piece.curve], piece, level, residual, out).run();
  }
  return out;
}

}  // namespace caustic::solver
