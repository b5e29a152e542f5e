#include "solver/total_grid.h"

#include <algorithm>
#include <cmath>

namespace caustic::solver {

namespace {

constexpr int kCells = 24;  // a side
constexpr int kHalvings = 30;
// Halvings until both ends lie in one face; what is nearer to a boundary is given up.
constexpr int kFaceHalvings = 16;
// Off the middle lines of symmetric scenes, on which their curves like to lie.
constexpr double kOffset = 0.0137;
// Beside an arc is so many chord tolerances from its polyline.
constexpr double kBesideArc = 2.0;

}  // namespace

TotalGrid::TotalGrid(SheetCarrier& carrier)
    : carrier_(carrier), half_(carrier.system().receiver().half), count_(kCells) {
  for (int j = 0; j <= count_; ++j) {
    for (int i = 0; i <= count_; ++i) {
      nodes_.push_back(node_at(place(i, j)));
    }
  }
}

Vec2 TotalGrid::place(int i, int j) const {
  const auto share = [&](int k) {
    return (2.0 * (k + kOffset) - count_) / count_ * (1.0 - 2.0 * kOffset / count_);
  };
  return {half_.x() * share(i), half_.y() * share(j)};
}

void TotalGrid::begin(double level) {
  level_ = level;
  right_.assign(nodes_.size(), {});
  above_ = right_;
  unsure_.assign(nodes_.size(), 0);
  given_up_above_ = given_up_right_ = unsure_;
}

TotalGrid::Node TotalGrid::node_at(const Vec2& q) {
  Branches branches = carrier_.find(q);
  const double total = total_of(branches).E;
  return {std::move(branches), total};
}

void TotalGrid::doubt_nodes_near(const Vec2& a, const Vec2& b, double distance) {
  const Vec2 origin = place(0, 0), step = place(1, 1) - origin, margin = Vec2::Constant(distance);
  const Vec2 lo = (a.cwiseMin(b) - margin - origin).cwiseQuotient(step),
             hi = (a.cwiseMax(b) + margin - origin).cwiseQuotient(step);
  const auto clamped = [&](double c) {
    return static_cast<int>(std::clamp(c, -1.0, count_ + 1.0));
  };
  const Vec2 along = b - a;
  for (int j = std::max(0, clamped(std::ceil(lo.y()))); j <= std::min(count_, clamped(hi.y()));
       ++j) {
    for (int i = std::max(0, clamped(std::ceil(lo.x()))); i <= std::min(count_, clamped(hi.x()));
         ++i) {
      const Vec2 to = place(i, j) - a;
      const double w = std::clamp(along.dot(to) / along.squaredNorm(), 0.0, 1.0);
      if ((to - w * along).norm() <= distance) unsure_[index(i, j)] = 1;
    }
  }
}

void TotalGrid::add(const std::vector<Vec2>& polyline, bool closed, double chord) {
  const Vec2 origin = place(0, 0), step = place(1, 1) - origin;
  const std::size_t n = polyline.size();
  chord_ = chord;
  for (std::size_t k = 0; k < (closed ? n : n - 1); ++k) {
    doubt_nodes_near(polyline[k], polyline[(k + 1) % n], chord);
    const Vec2 a = (polyline[k] - origin).cwiseQuotient(step);
    const Vec2 b = (polyline[(k + 1) % n] - origin).cwiseQuotient(step);
    for (const int axis : {0, 1}) {
      // Grid lines across `axis` between a and b: a line counts for the end on its upper side.
      const double lo = std::min(a[axis], b[axis]), hi = std::max(a[axis], b[axis]);
      const int first = std::max(0, static_cast<int>(std::floor(lo)) + 1);
      const int last = std::min(count_, static_cast<int>(std::floor(hi)));
      for (int line = first; line <= last; ++line) {
        const double w = (line - a[axis]) / (b[axis] - a[axis]);
        const double along = a[1 - axis] + w * (b[1 - axis] - a[1 - axis]);
        const int cell = static_cast<int>(std::floor(along));
        if (cell < 0 || cell >= count_) continue;
        if (axis == 0)
          above_[index(line, cell)].push_back(along - cell);
        else
          right_[index(cell, line)].push_back(along - cell);
      }
    }
  }
}

std::optional<TotalGrid::Place> TotalGrid::missing() {
  for (int j = 0; j <= count_; ++j) {
    for (int i = 0; i <= count_; ++i) {
      const Node& a = nodes_[index(i, j)];
      const auto look = [&](int di, int dj, const std::vector<std::vector<double>>& passed,
                            std::vector<char>& given_up) -> std::optional<Place> {
        if (i + di > count_ || j + dj > count_ || given_up[index(i, j)]) return std::nullopt;
        if (unsure_[index(i, j)] || unsure_[index(i + di, j + dj)]) return std::nullopt;
        const Node& b = nodes_[index(i + di, j + dj)];
        const bool differ = (a.total >= level_) != (b.total >= level_);
        const std::vector<double>& shares = passed[index(i, j)];
        if (differ == (shares.size() % 2 == 1)) return std::nullopt;
        given_up[index(i, j)] = 1;
        auto at = level_on_edge(a, place(i, j), b, place(i + di, j + dj), shares);
        if (!at) ++undecided_;
        return at;
      };
      if (auto at = look(1, 0, right_, given_up_right_)) return at;
      if (auto at = look(0, 1, above_, given_up_above_)) return at;
    }
  }
  return std::nullopt;
}

// The level between two neighbouring places that arcs pass, or a node and one: it is sought where
// the total says that one more lies between.
std::optional<TotalGrid::Place> TotalGrid::level_on_edge(const Node& a, const Vec2& qa,
                                                         const Node& b, const Vec2& qb,
                                                         std::vector<double> passed) {
  std::sort(passed.begin(), passed.end());
  const double margin = kBesideArc * chord_ / (qb - qa).norm();
  for (std::size_t k = 0; k <= passed.size(); ++k) {
    const double begin = k == 0 ? 0.0 : passed[k - 1] + margin;
    const double end = k == passed.size() ? 1.0 : passed[k] - margin;
    if (!(begin < end)) continue;
    const Vec2 from = qa + begin * (qb - qa), to = qa + end * (qb - qa);
    const Node first = k == 0 ? a : node_at(from), last = k == passed.size() ? b : node_at(to);
    if ((first.total >= level_) == (last.total >= level_)) continue;
    if (auto at = level_between(first, from, last, to)) return at;
  }
  return std::nullopt;
}

// By halving, with the sheets carried once both ends have the same.
std::optional<TotalGrid::Place> TotalGrid::level_between(Node a, Vec2 qa, Node b, Vec2 qb) {
  for (int k = 0; k < kFaceHalvings; ++k) {
    if (auto place = level_in_face(a, qa, b, qb)) return place;
    const Vec2 middle = 0.5 * (qa + qb);
    Branches branches = carrier_.find(middle);
    const double total = total_of(branches).E;
    const bool with_a = (total >= level_) == (a.total >= level_);
    (with_a ? a : b) = {std::move(branches), total};
    (with_a ? qa : qb) = middle;
  }
  return std::nullopt;
}

std::optional<TotalGrid::Place> TotalGrid::level_in_face(const Node& a, const Vec2& qa,
                                                         const Node& b, const Vec2& qb) {
  Branches at = a.branches, there = at;
  if (at.empty() || at.size() != b.branches.size() || !carrier_.carry(there, qb) ||
      (total_of(there).E >= level_) == (a.total >= level_))
    return std::nullopt;
  double lo = 0.0, hi = 1.0;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (lo + hi);
    Branches next = at;
    if (!carrier_.carry(next, (1.0 - middle) * qa + middle * qb)) break;
    ((total_of(next).E >= level_) == (a.total >= level_) ? lo : hi) = middle;
    at.swap(next);
  }
  const Vec2 q = (1.0 - lo) * qa + lo * qb;
  if (!carrier_.carry(at, q)) return std::nullopt;
  return Place{q, std::move(at)};
}

}  // namespace caustic::solver
