// Boxes about what apertures admit, from any side: linear programs in three dimensions. NOTATION.md
// (S90).
#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/aperture.h"
#include "geometry/expression/expression_bound.h"

namespace caustic::geometry {

namespace {

// A cylinder lies in the prism of so many sides about it.
constexpr int kPrismSides = 8;
// Normals that span less volume than this hardly bound anything, and are left out.
constexpr double kLeastVolume = 1e-6;
// What rounding may take off a bound, as a share of its terms.
constexpr double kBoundRounding = 1e-12;
// Sides of a box move in by these shares of its width, as often as nothing is there.
constexpr double kSideShares[] = {0.25, 0.0625};
constexpr int kMostMoves = 400;

/// n·x ≤ c.
struct HalfSpace {
  Direction n;
  double c;
  bool oblique() const { return n.cwiseAbs().maxCoeff() != 1.0; }
};

std::vector<HalfSpace> half_spaces_about(const std::vector<Bound>& bounds) {
  std::vector<HalfSpace> out;
  const auto touching = [&](const Bound& b, const Direction& n) {
    out.push_back({n, n.dot(b.point) + b.radius});
  };
  for (const Bound& b : bounds) {
    const bool ball = b.kind == Bound::Kind::ball, cylinder = b.kind == Bound::Kind::cylinder;
    if (b.kind == Bound::Kind::half_space) touching(b, b.axis);
    for (int i = 0; i < 3 && (ball || cylinder); ++i) {
      if (cylinder && b.axis[i] != 0.0) continue;
      touching(b, Vec3::Unit(i));
      touching(b, -Vec3::Unit(i));
    }
    const bool oblique = cylinder && b.axis.cwiseAbs().maxCoeff() != 1.0;
    const Frame across(b.axis);
    for (int k = 0; k < kPrismSides && oblique; ++k) {
      const double angle = 2.0 * kPi * k / kPrismSides;
      touching(b, std::cos(angle) * across.e1 + std::sin(angle) * across.e2);
    }
  }
  return out;
}

// Weights λ ≥ 0 with Σ λ n = ±e_i prove ±x_i ≤ Σ λ c; the best of all triples is the least bound.
void bound_by(const std::array<HalfSpace, 3>& three, Box& box) {
  Mat3 normals;
  normals << three[0].n, three[1].n, three[2].n;
  if (!(std::abs(normals.determinant()) > kLeastVolume)) return;
  const Mat3 weights = normals.inverse();
  const Vec3 c(three[0].c, three[1].c, three[2].c);
  for (int i = 0; i < 3; ++i) {
    const Vec3 lambda = weights.col(i), terms = lambda.cwiseProduct(c);
    const double slack = kBoundRounding * lambda.cwiseAbs().maxCoeff();
    const double beyond = kBoundRounding * terms.cwiseAbs().sum();
    if (lambda.minCoeff() >= -slack) box.max[i] = std::min(box.max[i], terms.sum() + beyond);
    if (lambda.maxCoeff() <= slack) box.min[i] = std::max(box.min[i], terms.sum() - beyond);
  }
}

bool excluded(const Box& box, const std::vector<Bound>& bounds) {
  return std::any_of(bounds.begin(), bounds.end(), [&](const Bound& b) {
    return b.kind == Bound::Kind::expression && b.expression->range(box).lo > 0.0;
  });
}

}  // namespace

Box box_of(const std::vector<Bound>& bounds) {
  Box box;
  const auto all = half_spaces_about(bounds);
  for (const HalfSpace& h : all) {
    for (int i = 0; i < 3; ++i) {
      if (h.n[i] == 1.0) box.max[i] = std::min(box.max[i], h.c);
      if (h.n[i] == -1.0) box.min[i] = std::max(box.min[i], -h.c);
    }
  }
  if (std::none_of(all.begin(), all.end(), [](const auto& h) { return h.oblique(); })) return box;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      for (std::size_t k = 0; k < j; ++k) bound_by({all[i], all[j], all[k]}, box);
    }
  }
  return box;
}

Box without_excluded_sides(Box box, const std::vector<Bound>& bounds) {
  const auto expression = [](const Bound& b) { return b.kind == Bound::Kind::expression; };
  if (!box.bounded() || std::none_of(bounds.begin(), bounds.end(), expression)) return box;
  int moves = 0;
  for (const double share : kSideShares) {
    for (int last = 0, side = 0; side - last < 6 && moves < kMostMoves; ++side, ++moves) {
      const int i = side / 2 % 3;
      const double width = share * (box.max[i] - box.min[i]);
      Box slab = box;
      double &old = side % 2 ? box.max[i] : box.min[i],
             &inner = side % 2 ? slab.min[i] : slab.max[i];
      inner = side % 2 ? old - width : old + width;
      if (!excluded(slab, bounds)) continue;
      old = inner;
      last = side;
    }
  }
  return box;
}

}  // namespace caustic::geometry
