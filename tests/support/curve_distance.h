// How far curves drawn as polylines are from each other, both ways, segments and not only vertices.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry/linear.h"

namespace caustic::test {

/// Points in order; a closed line repeats its first.
using Line = std::vector<geometry::Vec2>;

/// The nearest place of many lines. Segments that follow each other are near each other, so a
/// binary tree over their order is a good tree of boxes.
class NearestOnLines {
 public:
  explicit NearestOnLines(const std::vector<Line>& lines);

  bool empty() const { return segments_.empty(); }
  struct Place {
    double distance;      ///< infinite if there are no lines
    std::size_t line;     ///< as they were given
    std::size_t segment;  ///< of all lines, in their order: a hint for a question near this one
  };
  Place to(const geometry::Vec2& q, std::size_t hint = 0) const;

 private:
  struct Segment {
    geometry::Vec2 from, along;  // a line of one point is a segment of no length
    std::size_t line;
  };
  struct Rectangle {
    geometry::Vec2 min, max;
  };
  double squared_distance(std::size_t segment, const geometry::Vec2& q) const;
  double squared_distance(const Rectangle& box, const geometry::Vec2& q) const;
  Rectangle make_boxes(std::size_t node, std::size_t begin, std::size_t end);
  void search(std::size_t node, std::size_t begin, std::size_t end, const geometry::Vec2& q,
              double& best, std::size_t& nearest) const;

  std::vector<Segment> segments_;
  std::vector<Rectangle> boxes_;  // children of node i are 2i + 1 and 2i + 2
};

/// Distances of one set of lines from another, weighted by length.
struct CurveDistance {
  double max = 0.0, sum = 0.0, length = 0.0;
  geometry::Vec2 farthest = geometry::Vec2::Zero();  ///< the place that is `max` away

  double mean() const { return length > 0.0 ? sum / length : max; }
  void add(const CurveDistance& other);
};

/// Samples of a line: no further apart than `spacing`, and no fewer than `least` a segment; odd
/// numbers see the middle, where a chord is farthest from its arc.
struct Sampling {
  double spacing;
  int least;
};

/// How far `lines` are from `others`, for each kind of these by itself: `kinds[i]` of others[i],
/// from 0 to `count` − 1. What has nothing to be near to is `lost` away, of kind 0.
std::vector<CurveDistance> distances(const std::vector<Line>& lines, const NearestOnLines& others,
                                     const std::vector<int>& kinds, int count,
                                     const Sampling& sampling, double lost);

}  // namespace caustic::test
