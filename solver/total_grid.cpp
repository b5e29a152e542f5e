#include "solver/total_grid.h"

#include <algorithm>
#include <cmath>

#include "solver/critical_points.h"

namespace caustic::solver {

namespace {

constexpr int kCells = 16;  // a side
constexpr int kHalvings = 30;
// Halvings until both ends lie in one face; what is nearer to a boundary is given up.
constexpr int kFaceHalvings = 16;
// Off the middle lines of symmetric scenes, on which their curves like to lie.
constexpr double kOffset = 0.0137;
// Beside an arc is so many chord tolerances from its polyline.
constexpr double kBesideArc = 2.0;
// In cells: how far an extreme may be from where it is sought, and how near to it a node is no end
// of its spoke. Extremes whose places, in cells, or totals differ by less than the last are one.
constexpr double kRoamCells = 3.0;
constexpr double kTooNear = 0.05;
constexpr double kSameExtreme = 1e-7;
// Of one family, on one side of a fold, this near to each other as a share of the scene.
constexpr double kSameSheet = 1e-6;

}  // namespace

TotalGrid::TotalGrid(SheetCarrier& carrier)
    : carrier_(carrier), half_(carrier.system().receiver().half), count_(kCells) {
  for (int j = 0; j <= count_; ++j) {
    for (int i = 0; i <= count_; ++i) {
      nodes_.push_back(node_at(place(i, j)));
    }
  }
  find_spokes();
}

void TotalGrid::find_spokes() {
  const auto extreme = [&](int i, int j, double sign) {
    const double E = sign * nodes_[index(i, j)].total;
    for (int n = std::max(0, j - 1); n <= std::min(count_, j + 1); ++n) {
      for (int m = std::max(0, i - 1); m <= std::min(count_, i + 1); ++m) {
        if (sign * nodes_[index(m, n)].total > E) return false;
      }
    }
    return true;
  };
  for (int j = 0; j <= count_; ++j) {
    for (int i = 0; i <= count_; ++i) {
      if (extreme(i, j, 1.0) || extreme(i, j, -1.0))
        add_spoke(place(i, j), nodes_[index(i, j)].branches);
    }
  }
  for (int k = 0; k < carrier_.field_count(); ++k) {
    for (const CriticalPoint& c : carrier_.field(k).critical) {
      if (carrier_.system().receiver().contains(c.field.q))
        add_spoke(c.field.q, carrier_.find(c.field.q));
    }
  }
}

// To the node that is nearest but not so near that it may be the same place.
void TotalGrid::add_spoke(const Vec2& start, const Branches& branches) {
  const Vec2 origin = place(0, 0), step = place(1, 1) - origin;
  auto found = settle(carrier_, start, branches, kRoamCells * step.maxCoeff());
  if (!found || found->type == CriticalType::saddle) return;
  const auto known = [&](const Spoke& spoke) {
    return (spoke.from - found->q).norm() <= kSameExtreme * step.norm();
  };
  if (std::any_of(spokes_.begin(), spokes_.end(), known)) return;
  // Sheets may have begun on the way that were not carried.
  Node node = node_at(found->q);
  if (std::abs(node.total - found->total.E) > kSameExtreme * node.total) return;
  const Vec2 share = (found->q - origin).cwiseQuotient(step);
  const auto nearest = [&](double at) {
    const int k = static_cast<int>(std::lround(at));
    const int beside = std::abs(at - k) > kTooNear ? k : k < count_ ? k + 1 : k - 1;
    return std::clamp(beside, 0, count_);
  };
  const int i = nearest(share.x()), j = nearest(share.y());
  spokes_.push_back({std::move(node), nodes_[index(i, j)], found->q, place(i, j)});
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
  for (Spoke& spoke : spokes_) {
    spoke.passed.clear();
    spoke.unsure = spoke.given_up = false;
  }
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
    add_to_spokes(polyline[k], polyline[(k + 1) % n], chord);
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

void TotalGrid::add_to_spokes(const Vec2& a, const Vec2& b, double distance) {
  const Vec2 along = b - a;
  const auto near = [&](const Vec2& q) {
    const double w = std::clamp(along.dot(q - a) / along.squaredNorm(), 0.0, 1.0);
    return (q - a - w * along).norm() <= distance;
  };
  for (Spoke& spoke : spokes_) {
    spoke.unsure = spoke.unsure || near(spoke.from) || near(spoke.to);
    // A crossing counts for one of two segments that meet on the spoke.
    const Vec2 way = spoke.to - spoke.from, across(-way.y(), way.x());
    const double before = across.dot(a - spoke.from), after = across.dot(b - spoke.from);
    if ((before > 0.0) == (after > 0.0)) continue;
    const Vec2 at = a + before / (before - after) * along;
    const double share = way.dot(at - spoke.from) / way.squaredNorm();
    if (share >= 0.0 && share <= 1.0) spoke.passed.push_back(share);
  }
}

std::optional<TotalGrid::Place> TotalGrid::missing_on(Spoke& spoke) {
  if (spoke.unsure || spoke.given_up) return std::nullopt;
  const bool differ = (spoke.extreme.total >= level_) != (spoke.end.total >= level_);
  if (differ == (spoke.passed.size() % 2 == 1)) return std::nullopt;
  spoke.given_up = true;
  auto at = level_on_edge(spoke.extreme, spoke.from, spoke.end, spoke.to, spoke.passed);
  if (!at) ++undecided_;
  return at;
}

std::optional<TotalGrid::Place> TotalGrid::missing() {
  for (Spoke& spoke : spokes_) {
    if (auto at = missing_on(spoke)) return at;
  }

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
        if (complete(index(i, j), place(i, j), index(i + di, j + dj), place(i + di, j + dj)))
          return missing();
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

// Sheets that are carried from one to the other of two nodes and exist there, but were not found.
bool TotalGrid::complete(std::size_t a, const Vec2& qa, std::size_t b, const Vec2& qb) {
  const auto add_to = [&](Node& node, const Vec2& q, const Branches& from) {
    bool added = false;
    for (const Branch& branch : from) {
      const auto at = carrier_.carry(branch.field, branch.at, q);
      if (!at || !at->arrives() || carrier_.field(branch.field).domain.worst(*at).value > 0.0 ||
          carrier_.hidden(branch.field, *at))
        continue;
      const double same = kSameSheet * carrier_.system().diameter();
      const bool known =
          std::any_of(node.branches.begin(), node.branches.end(), [&](const Branch& other) {
            return other.field == branch.field && other.at.a * at->a > 0.0 &&
                   (other.at.x - at->x).norm() <= same;
          });
      if (known) continue;
      node.branches.push_back({branch.field, *at});
      added = true;
    }
    if (added) node.total = total_of(node.branches).E;
    return added;
  };
  const Branches of_a = nodes_[a].branches;
  const bool to_a = add_to(nodes_[a], qa, nodes_[b].branches), to_b = add_to(nodes_[b], qb, of_a);
  return to_a || to_b;
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
