#include "solver/deepest_point.h"

#include <algorithm>
#include <cmath>
#include <queue>

namespace caustic::solver {

using geometry::Vec2;

namespace {

constexpr int kMaxSquares = 2000;

// A square that holds no point deeper than `most`.
struct Square {
  Vec2 middle;
  double half, depth, most;
  bool operator<(const Square& other) const { return most < other.most; }
};

template <class F>
void for_each_edge(const std::vector<Vec2>& ring, const F& edge) {
  for (std::size_t i = 0; i < ring.size(); ++i) edge(ring[i], ring[(i + 1) % ring.size()]);
}

double distance_to_edge(const Vec2& q, const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double length2 = along.squaredNorm();
  const double w = length2 > 0.0 ? std::clamp((q - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (q - a - w * along).norm();
}

// Negative outside.
double depth_at(const std::vector<std::vector<Vec2>>& rings, const Vec2& q) {
  bool inside = false;
  double nearest = geometry::kInfinity;
  for (const auto& ring : rings) {
    inside ^= surrounds(ring, q);
    for_each_edge(ring, [&](const Vec2& a, const Vec2& b) {
      nearest = std::min(nearest, distance_to_edge(q, a, b));
    });
  }
  return inside ? nearest : -nearest;
}

}  // namespace

double twice_area(const std::vector<Vec2>& ring) {
  double sum = 0.0;
  const Vec2 origin = ring.empty() ? Vec2(0, 0) : ring.front();
  for_each_edge(ring, [&](const Vec2& a, const Vec2& b) {
    sum += (a - origin).x() * (b - origin).y() - (a - origin).y() * (b - origin).x();
  });
  return sum;
}

bool surrounds(const std::vector<Vec2>& ring, const Vec2& q) {
  bool odd = false;
  for_each_edge(ring, [&](const Vec2& a, const Vec2& b) {
    if ((a.x() > q.x()) == (b.x() > q.x())) return;
    odd ^= a.y() + (q.x() - a.x()) / (b.x() - a.x()) * (b.y() - a.y()) > q.y();
  });
  return odd;
}

// Squares that may hold something deeper than what is known are divided, the most promising first:
// within a square no point is deeper than its middle by more than half a diagonal.
DeepestPoint deepest_point(const std::vector<std::vector<Vec2>>& rings, double precision) {
  Vec2 lo = Vec2::Constant(geometry::kInfinity), hi = -lo;
  for (const auto& ring : rings) {
    for (const Vec2& q : ring) lo = lo.cwiseMin(q), hi = hi.cwiseMax(q);
  }
  DeepestPoint best{0.5 * (lo + hi), -geometry::kInfinity};
  std::priority_queue<Square> squares;
  const auto look_at = [&](const Vec2& middle, double half) {
    const double depth = depth_at(rings, middle);
    if (depth > best.depth) best = {middle, depth};
    squares.push({middle, half, depth, depth + half * std::sqrt(2.0)});
  };
  look_at(best.at, 0.5 * (hi - lo).maxCoeff());
  for (int i = 0; i < kMaxSquares && !squares.empty(); ++i) {
    const Square square = squares.top();
    squares.pop();
    if (square.most <= best.depth + precision) break;
    const double half = 0.5 * square.half;
    for (const double v : {-half, half}) {
      for (const double u : {-half, half}) look_at(square.middle + Vec2(u, v), half);
    }
  }
  return best;
}

}  // namespace caustic::solver
