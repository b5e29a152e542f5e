#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/expression/leaves.h"

namespace caustic::geometry {

namespace {

/// A larger leaf must be a flatter graph than one that cannot be avoided.
constexpr double kMergedSteepest = 8.0;
/// The rectangle of a merged leaf may be larger than those of its parts by this factor: a chart is
/// explored all over.
constexpr double kMostWaste = 1.3;
/// Leaves whose slices without zero were cut off still count as neighbours, at this share of their
/// size.
constexpr double kGapShare = 0.3;
/// More leaves than these stay as they are: the work grows with the square of their number.
constexpr std::size_t kMostLeaves = 1000;

Box hull(const Box& a, const Box& b) { return {a.min.cwiseMin(b.min), a.max.cwiseMax(b.max)}; }

bool within(const Box& inner, const Box& outer) {
  return (inner.min.array() >= outer.min.array()).all() &&
         (inner.max.array() <= outer.max.array()).all();
}
bool overlap(const Box& a, const Box& b) {
  return (a.min.array() < b.max.array()).all() && (b.min.array() < a.max.array()).all();
}
bool near(const Box& a, const Box& b) {
  const Vec3 gap = kGapShare * (a.max - a.min).cwiseMax(b.max - b.min);
  return (a.min.array() <= (b.max + gap).array()).all() &&
         (b.min.array() <= (a.max + gap).array()).all();
}

/// Halvings of a leaf, in turns along its axes, until what may hold a zero is known well enough.
constexpr int kHalvings = 12;

// Widens `found` to hold all zeros in the box.
void include_zeros(const Field& field, const Box& box, int halvings, Box& found) {
  if (within(box, found)) return;
  Interval g;
  field.enclose(intervals(box), g);
  if (!g.contains_zero()) return;
  if (halvings == 0) {
    found = hull(found, box);
    return;
  }
  const int axis = halvings % 3;
  Box low = box, high = box;
  low.max[axis] = high.min[axis] = box.center()[axis];
  include_zeros(field, low, halvings - 1, found);
  include_zeros(field, high, halvings - 1, found);
}

// Cuts from `other` what lies in `box`; false if more than one box would be left.
bool cut_off(const Box& box, Box& other) {
  int axis = -1;
  for (int k = 0; k < 3; ++k) {
    if (other.min[k] >= box.min[k] && other.max[k] <= box.max[k]) continue;
    if (axis >= 0) return false;
    axis = k;
  }
  if (axis < 0) return false;
  const bool below = other.min[axis] < box.min[axis];
  if (below && other.max[axis] > box.max[axis]) return false;
  (below ? other.max : other.min)[axis] = (below ? box.min : box.max)[axis];
  return true;
}

double rectangle(const Leaf& leaf) {
  const Vec3 size = leaf.box.max - leaf.box.min;
  return size[(leaf.axis + 1) % 3] * size[(leaf.axis + 2) % 3];
}

// The box without what is empty for sure.
Box tightened(const Field& field, const Box& box) {
  Box found{Point::Constant(kInfinity), Point::Constant(-kInfinity)};
  include_zeros(field, box, kHalvings, found);
  return found;
}

/// Halvings of a box until intervals prove all of it a graph.
constexpr int kProofHalvings = 6;

// Along which axes the zero set in a box is proven to be a graph no steeper than allowed (S18):
// there the field grows (1) or falls (−1) all over the box; 0 along others.
class GraphProof {
 public:
  GraphProof(const Field& field, const Box& box) : field_(field) { look(box, kProofHalvings); }
  // The axis along which it is flattest, −1 if there is none.
  int axis() const {
    int best = -1;
    for (int k = 0; k < 3; ++k) {
      if (sign_[k] != 0 && (best < 0 || steepest_[k] < steepest_[best])) best = k;
    }
    return best;
  }

 private:
  bool hopeless() const { return sign_[0] == 0 && sign_[1] == 0 && sign_[2] == 0; }

  void look(const Box& box, int halvings) {
    Vec3 slope;
    field_.value_gradient(box.center(), slope);
    for (int k = 0; k < 3; ++k) {
      const int sign = slope[k] > 0.0 ? 1 : -1;
      if (sign_[k] == kOpen) sign_[k] = sign;
      if (sign != sign_[k]) sign_[k] = 0;
    }
    if (hopeless()) return;
    Interval g;
    IntervalVec3 gradient;
    const bool defined = field_.enclose(intervals(box), g, gradient);
    std::array<double, 3> steep;
    bool proven = defined;
    for (int k = 0; k < 3; ++k) {
      const double across =
          std::hypot(gradient[(k + 1) % 3].magnitude(), gradient[(k + 2) % 3].magnitude());
      const double least = gradient[k].mignitude();
      // How steep the field is matters where the surface is, its sign everywhere.
      steep[k] = least == 0.0 ? kInfinity : g.contains_zero() ? across / least : 0.0;
      proven &= sign_[k] == 0 || steep[k] <= kMergedSteepest;
    }
    if (!proven && defined && halvings > 0) {
      const int axis = halvings % 3;
      Box low = box, high = box;
      low.max[axis] = high.min[axis] = box.center()[axis];
      look(low, halvings - 1);
      if (!hopeless()) look(high, halvings - 1);
      return;
    }
    for (int k = 0; k < 3; ++k) {
      if (!defined || !(steep[k] <= kMergedSteepest)) sign_[k] = 0;
      steepest_[k] = std::max(steepest_[k], steep[k]);
    }
  }

  static constexpr int kOpen = 2;
  const Field& field_;
  std::array<int, 3> sign_{kOpen, kOpen, kOpen};
  std::array<double, 3> steepest_{};
};

class Merger {
 public:
  Merger(const Field& field, const Leaves& leaves)
      : field_(field), undecided_(leaves.undecided), leaves_(leaves.graphs) {}

  std::vector<Leaf> operator()() {
    if (leaves_.size() > kMostLeaves) return std::move(leaves_);
    for (Leaf& leaf : leaves_) tighten(leaf);
    std::erase_if(leaves_, gone);
    while (pass()) {
    }
    std::erase_if(leaves_, gone);
    return std::move(leaves_);
  }

 private:
  static bool gone(const Leaf& leaf) { return leaf.axis < 0; }
  void tighten(Leaf& leaf) const {
    leaf.box = tightened(field_, leaf.box);
    if (leaf.box.empty()) leaf.axis = -1;
  }

  // True if anything was merged.
  bool pass() {
    bool any = false;
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
      for (std::size_t j = i + 1; j < leaves_.size() && !gone(leaves_[i]); ++j) {
        if (gone(leaves_[j]) || !near(leaves_[i].box, leaves_[j].box)) continue;
        any |= merge(leaves_[i], leaves_[j].box);
      }
    }
    return any;
  }

  // The first becomes the hull of both and takes from others what lies within: all that the surface
  // has there is on its graph.
  bool merge(Leaf& first, const Box& second) {
    const Box box = hull(first.box, second);
    double parts = 0.0;
    for (const Leaf& leaf : leaves_) {
      if (gone(leaf) || !overlap(leaf.box, box)) continue;
      Box rest = leaf.box;
      if (!within(leaf.box, box) && !cut_off(box, rest)) return false;
      parts += rectangle({leaf.box.intersected(box), leaf.axis});
    }
    const auto overlaps = [&](const Box& other) { return overlap(other, box); };
    if (std::any_of(undecided_.begin(), undecided_.end(), overlaps)) return false;
    const Leaf whole{box, GraphProof(field_, box).axis()};
    if (whole.axis < 0 || rectangle(whole) > kMostWaste * parts) return false;
    for (Leaf& leaf : leaves_) {
      if (gone(leaf) || !overlap(leaf.box, box)) continue;
      if (within(leaf.box, box)) {
        leaf.axis = -1;
      } else {
        cut_off(box, leaf.box);
        tighten(leaf);
      }
    }
    first = whole;
    return true;
  }

  const Field& field_;
  const std::vector<Box>& undecided_;
  std::vector<Leaf> leaves_;
};

}  // namespace

std::vector<Leaf> merged(const Field& field, const Leaves& leaves) {
  return Merger(field, leaves)();
}

}  // namespace caustic::geometry
