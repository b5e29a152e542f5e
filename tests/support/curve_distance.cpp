#include "tests/support/curve_distance.h"

#include <algorithm>
#include <cmath>

namespace caustic::test {

using geometry::Vec2;

namespace {

// Segments that are looked at one by one.
constexpr std::size_t kLinearSearch = 4;

}  // namespace

NearestOnLines::NearestOnLines(const std::vector<Line>& lines) {
  for (std::size_t line = 0; line < lines.size(); ++line) {
    const Line& points = lines[line];
    if (points.size() == 1) segments_.push_back({points[0], Vec2::Zero(), line});
    for (std::size_t i = 1; i < points.size(); ++i)
      segments_.push_back({points[i - 1], points[i] - points[i - 1], line});
  }
  if (empty()) return;
  std::size_t nodes = 1;
  for (std::size_t most = segments_.size(); most > kLinearSearch; most = (most + 1) / 2)
    nodes = 2 * nodes + 1;
  boxes_.resize(nodes);
  make_boxes(0, 0, segments_.size());
}

NearestOnLines::Rectangle NearestOnLines::make_boxes(std::size_t node, std::size_t begin,
                                                     std::size_t end) {
  Rectangle& box = boxes_[node];
  if (end - begin > kLinearSearch) {
    const std::size_t middle = begin + (end - begin) / 2;
    const Rectangle a = make_boxes(2 * node + 1, begin, middle),
                    b = make_boxes(2 * node + 2, middle, end);
    return box = {a.min.cwiseMin(b.min), a.max.cwiseMax(b.max)};
  }
  box = {segments_[begin].from, segments_[begin].from};
  for (std::size_t i = begin; i < end; ++i) {
    const Segment& s = segments_[i];
    for (const Vec2& q : {s.from, Vec2(s.from + s.along)})
      box = {box.min.cwiseMin(q), box.max.cwiseMax(q)};
  }
  return box;
}

double NearestOnLines::squared_distance(std::size_t segment, const Vec2& q) const {
  const Segment& s = segments_[segment];
  const Vec2 d = q - s.from;
  const double length = s.along.squaredNorm();
  const double t = length > 0.0 ? std::clamp(d.dot(s.along) / length, 0.0, 1.0) : 0.0;
  return (d - t * s.along).squaredNorm();
}

double NearestOnLines::squared_distance(const Rectangle& box, const Vec2& q) const {
  return (box.min - q).cwiseMax(q - box.max).cwiseMax(0.0).squaredNorm();
}

void NearestOnLines::search(std::size_t node, std::size_t begin, std::size_t end, const Vec2& q,
                            double& best, std::size_t& nearest) const {
  if (end - begin > kLinearSearch) {
    const std::size_t middle = begin + (end - begin) / 2;
    const double a = squared_distance(boxes_[2 * node + 1], q),
                 b = squared_distance(boxes_[2 * node + 2], q);
    for (const bool first : {a <= b, a > b}) {  // the nearer half first
      if ((first ? a : b) >= best) continue;
      first ? search(2 * node + 1, begin, middle, q, best, nearest)
            : search(2 * node + 2, middle, end, q, best, nearest);
    }
    return;
  }
  for (std::size_t i = begin; i < end; ++i) {
    const double d = squared_distance(i, q);
    if (d < best) best = d, nearest = i;
  }
}

NearestOnLines::Place NearestOnLines::to(const Vec2& q, std::size_t hint) const {
  if (empty()) return {geometry::kInfinity, 0, 0};
  std::size_t nearest = std::min(hint, segments_.size() - 1);
  double best = squared_distance(nearest, q);
  search(0, 0, segments_.size(), q, best, nearest);
  return {std::sqrt(best), segments_[nearest].line, nearest};
}

void CurveDistance::add(const CurveDistance& other) {
  if (other.max > max) max = other.max, farthest = other.farthest;
  sum += other.sum;
  length += other.length;
}

std::vector<CurveDistance> distances(const std::vector<Line>& lines, const NearestOnLines& others,
                                     const std::vector<int>& kinds, int count,
                                     const Sampling& sampling, double lost) {
  std::vector<CurveDistance> found(count);
  std::size_t hint = 0;
  const auto sample = [&](const Vec2& q, double weight) {
    const auto place = others.to(q, hint);
    hint = place.segment;
    const double d = std::min(place.distance, lost);
    found[others.empty() ? 0 : kinds[place.line]].add({d, weight * d, weight, q});
  };
  for (const Line& line : lines) {
    if (!line.empty()) sample(line.front(), 0.0);
    for (std::size_t i = 1; i < line.size(); ++i) {
      const Vec2 along = line[i] - line[i - 1];
      const double length = along.norm();
      const int n =
          std::max(sampling.least, static_cast<int>(std::ceil(length / sampling.spacing)));
      for (int k = 0; k < n; ++k) sample(line[i - 1] + ((k + 0.5) / n) * along, length / n);
      sample(line[i], 0.0);
    }
  }
  return found;
}

}  // namespace caustic::test
