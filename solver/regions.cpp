#include "solver/regions.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "solver/deepest_point.h"

namespace caustic::solver {

namespace {

// Ends of pieces this near, in widths of the receiver, meet.
constexpr double kMeetShare = 1e-7;
// Directions at a vertex are those towards where pieces leave a circle about it, of this share of
// the receiver's width or less. Nearer to each other than this angle, they may be in the wrong
// order: polylines are within the chord tolerance only.
constexpr double kCircleShare = 5e-3;
constexpr double kSameDirection = 0.05;
// Faces are no deeper than this share of the receiver's width if they are nothing but rounding, and
// points inside as deep as possible to this share.
constexpr double kNoDepth = 1e-6;
constexpr double kDepthPrecision = 2e-3;
// Areas that differ by no more than this share are those of the two sides of one piece.
constexpr double kSameArea = 1e-12;

// A piece, run through with the face in question on its left.
struct Side {
  std::vector<Vec2> line;
  int twin;  // the same piece the other way round; −1 on the receiver's edge
  bool closed;
  int branches;  // on the left; −1 where they could not be followed
};

struct Ring {
  std::vector<Vec2> line;  // first point not repeated
  int branches;
};

class FaceFinder {
 public:
  FaceFinder(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves,
             const std::vector<BoundaryPiece>& pieces, double largest)
      : carrier_(carrier), width_(carrier.system().receiver().width()), largest_(largest) {
    for (const BoundaryPiece& piece : pieces) add(curves[piece.curve], piece);
  }

  Regions run() {
    join();
    gather();
    return std::move(out_);
  }

 private:
  void add(const BoundaryCurve& curve, const BoundaryPiece& piece);
  void join();
  void gather();
  void take(const std::vector<std::vector<Vec2>>& rings, int branches);
  std::optional<int> next_of(int side) const;

  SheetCarrier& carrier_;
  double width_, largest_;
  std::vector<Side> sides_;
  std::vector<Ring> rings_;
  Regions out_;
};

// Sheets on the left of a piece run forwards, its inside, or backwards.
int branches_beside(const BoundaryCurve& curve, const BoundaryPiece& piece, bool inside) {
  const auto& v = piece.vertices;
  const std::size_t middle = v.size() / 2;
  for (std::size_t k = 0; k < v.size(); ++k) {
    // From the middle outwards.
    const std::size_t i = k % 2 ? middle - (k + 1) / 2 : middle + k / 2;
    if (i >= v.size() || !v[i].followed) continue;
    const int second = inside && curve.kind == BoundaryKind::caustic;  // of the pair born there
    return static_cast<int>(branches_on(curve, v[i], inside).size()) + second;
  }
  return -1;
}

void FaceFinder::add(const BoundaryCurve& curve, const BoundaryPiece& piece) {
  std::vector<Vec2> line;
  for (const BoundaryVertex& v : piece.vertices) line.push_back(v.at.q);
  if (piece.closed) line.pop_back();  // the first again
  if (line.size() < 2) return;
  const int first = static_cast<int>(sides_.size());
  const bool both = !curve.on_receiver_edge();
  sides_.push_back(
      {line, both ? first + 1 : -1, piece.closed, branches_beside(curve, piece, true)});
  if (!both) return;
  std::reverse(line.begin(), line.end());
  sides_.push_back({std::move(line), first, piece.closed, branches_beside(curve, piece, false)});
}

// Where a line leaves a circle about its first point, or its last point if it does not.
Vec2 leaves_circle(const std::vector<Vec2>& line, double radius, bool from_end) {
  const auto at = [&](std::size_t i) { return from_end ? line[line.size() - 1 - i] : line[i]; };
  const Vec2 center = at(0);
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vec2 a = at(i - 1) - center, b = at(i) - center, along = b - a;
    if (b.norm() < radius) continue;
    // |a + w·along| = radius
    const double half = a.dot(along), c = a.squaredNorm() - radius * radius;
    const double w = (-half + std::sqrt(std::max(0.0, half * half - along.squaredNorm() * c))) /
                     along.squaredNorm();
    return a + std::clamp(w, 0.0, 1.0) * along;
  }
  return at(line.size() - 1) - center;
}

double reach_of(const std::vector<Vec2>& line, const Vec2& from) {
  double most = 0.0;
  for (const Vec2& q : line) most = std::max(most, (q - from).norm());
  return most;
}

// The first piece clockwise from the way back keeps the face on the left. Of pieces that leave in
// directions too near to each other the one that has the same sheets on its left.
std::optional<int> FaceFinder::next_of(int side) const {
  const Side& from = sides_[side];
  const Vec2 vertex = from.line.back();
  std::vector<int> leaving;
  double radius = std::min(kCircleShare * width_, 0.5 * reach_of(from.line, vertex));
  for (int k = 0; k < static_cast<int>(sides_.size()); ++k) {
    const Side& to = sides_[k];
    if (to.closed || k == from.twin || (to.line.front() - vertex).norm() > kMeetShare * width_)
      continue;
    leaving.push_back(k);
    radius = std::min(radius, 0.5 * reach_of(to.line, vertex));
  }
  if (leaving.empty()) return from.twin < 0 ? std::nullopt : std::optional(from.twin);
  const Vec2 back = leaves_circle(from.line, radius, true);
  std::vector<std::pair<double, int>> by_angle;
  for (const int k : leaving) {
    const Vec2 way = leaves_circle(sides_[k].line, radius, false);
    const double angle = std::atan2(back.x() * way.y() - back.y() * way.x(), back.dot(way));
    by_angle.emplace_back(angle <= 0.0 ? -angle : 2.0 * geometry::kPi - angle, k);
  }
  std::sort(by_angle.begin(), by_angle.end());
  // What leaves along the way back may be the first or the last.
  const double full = 2.0 * geometry::kPi;
  std::vector<std::pair<double, int>> order;
  for (const auto& [angle, k] : by_angle)
    if (angle > full - kSameDirection) order.emplace_back(0.0, k);
  for (const auto& each : by_angle)
    if (each.first <= full - kSameDirection) order.push_back(each);
  double first_clear = -1.0;
  for (const auto& [angle, k] : order) {
    if (first_clear >= 0.0 && angle > first_clear + kSameDirection) break;
    if (sides_[k].branches == from.branches || sides_[k].branches < 0 || from.branches < 0)
      return k;
    if (angle > kSameDirection && first_clear < 0.0) first_clear = angle;
  }
  return std::nullopt;
}

void FaceFinder::join() {
  std::vector<char> used(sides_.size());
  for (int first = 0; first < static_cast<int>(sides_.size()); ++first) {
    if (used[first]) continue;
    Ring ring{{}, sides_[first].branches};
    std::optional<int> k = first;
    do {
      const Side& side = sides_[*k];
      used[*k] = 1;
      // The last point of an open side is the next one's first.
      ring.line.insert(ring.line.end(), side.line.begin(), side.line.end() - !side.closed);
      if (ring.branches < 0) ring.branches = side.branches;
      k = side.closed ? first : next_of(*k);
    } while (k && *k != first && !used[*k]);
    if (k && *k == first)
      rings_.push_back(std::move(ring));
    else
      ++out_.unresolved;
  }
}

// A ring that runs counterclockwise is the outer edge of a face; each other one is that of a hole
// in the smallest face about it.
void FaceFinder::gather() {
  std::vector<std::size_t> outer;
  std::vector<std::vector<std::vector<Vec2>>> faces;
  const double nothing = kNoDepth * kNoDepth * width_ * width_;
  for (std::size_t i = 0; i < rings_.size(); ++i) {
    if (twice_area(rings_[i].line) <= nothing) continue;
    outer.push_back(i);
    faces.push_back({rings_[i].line});
  }
  for (const Ring& hole : rings_) {
    if (twice_area(hole.line) > nothing) continue;
    std::optional<std::size_t> best;
    double least = geometry::kInfinity;
    for (std::size_t f = 0; f < outer.size(); ++f) {
      const Ring& about = rings_[outer[f]];
      const double area = twice_area(about.line);
      // Sides of one piece are the outer edge of what it surrounds and a hole in what surrounds it.
      const bool same =
          area <= -twice_area(hole.line) * (1.0 + kSameArea) ||
          (hole.branches >= 0 && about.branches >= 0 && hole.branches != about.branches);
      if (same || area >= least || !surrounds(about.line, hole.line.front())) continue;
      least = area;
      best = f;
    }
    if (best)
      faces[*best].push_back(hole.line);
    else
      ++out_.unresolved;
  }
  for (std::size_t f = 0; f < faces.size(); ++f) take(faces[f], rings_[outer[f]].branches);
  std::sort(out_.regions.begin(), out_.regions.end(), [](const Region& a, const Region& b) {
    return std::pair(a.uv_inside.x(), a.uv_inside.y()) <
           std::pair(b.uv_inside.x(), b.uv_inside.y());
  });
}

// As many sheets must be found inside as the face's edges say.
void FaceFinder::take(const std::vector<std::vector<Vec2>>& rings, int branches) {
  Vec2 lo = rings.front().front(), hi = lo;
  for (const Vec2& q : rings.front()) lo = lo.cwiseMin(q), hi = hi.cwiseMax(q);
  if ((hi - lo).minCoeff() > largest_) return;
  const DeepestPoint inside = deepest_point(rings, kDepthPrecision * width_);
  if (inside.depth <= kNoDepth * width_) return;
  const int found = static_cast<int>(carrier_.find(inside.at).size());
  if (branches >= 0 && branches != found)
    ++out_.unresolved;
  else
    out_.regions.push_back({inside.at, found});
}

}  // namespace

Regions find_regions(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves,
                     const std::vector<BoundaryPiece>& pieces, double largest) {
  return FaceFinder(carrier, curves, pieces, largest).run();
}

}  // namespace caustic::solver
