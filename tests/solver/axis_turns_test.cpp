// Edges between parts with different axes: against all pairs of parts, and against a closed curve.
#include "solver/axis_turns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "tests/support/random.h"

namespace caustic::solver {
namespace {

using Decide = std::function<bool(const ReceiverCell&)>;

// Halved, along the longer side, where `more` says so.
std::vector<ReceiverCell> subdivision(const ReceiverCell& all, const Decide& more) {
  std::vector<ReceiverCell> queue{all}, parts;
  while (!queue.empty()) {
    const ReceiverCell part = queue.back();
    queue.pop_back();
    if (!more(part)) {
      parts.push_back(part);
      continue;
    }
    ReceiverCell low = part, high = part;
    const bool along_u = part.u.width() >= part.v.width();
    (along_u ? low.u : low.v).hi = (along_u ? high.u : high.v).lo =
        (along_u ? part.u : part.v).middle();
    queue.push_back(low);
    queue.push_back(high);
  }
  return parts;
}

Axes axis(Axes axes) { return axes & kAlongU ? kAlongU : axes; }

// The piece of an edge that two parts share, if they do.
bool shared(const ReceiverCell& a, const ReceiverCell& b, Vec2& from, Vec2& to) {
  from = {std::max(a.u.lo, b.u.lo), std::max(a.v.lo, b.v.lo)};
  to = {std::min(a.u.hi, b.u.hi), std::min(a.v.hi, b.v.hi)};
  return (from.x() == to.x() && from.y() < to.y()) || (from.y() == to.y() && from.x() < to.x());
}

TEST(AxisTurns, AreAllEdgesBetweenDifferentAxes) {
  test::Random random(5);
  constexpr int kLevels = 3;
  for (int round = 0; round < 20; ++round) {
    std::vector<MonotonePart> parts;
    for (const ReceiverCell& part :
         subdivision({{-1.0, 1.0}, {0.0, 1.0}}, [&](const ReceiverCell& c) {
           return c.size() > 0.1 && random.uniform(0.0, 1.0) < 0.8;
         })) {
      parts.push_back({part, {}});
      for (int i = 0; i < kLevels; ++i) parts.back().axes.push_back(Axes(random.index(4)));
    }
    std::vector<AxisTurn::Key> expected, found;
    for (std::size_t a = 0; a < parts.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        Vec2 from, to;
        if (!shared(parts[a].part, parts[b].part, from, to)) continue;
        for (int i = 0; i < kLevels; ++i) {
          const Axes one = axis(parts[a].axes[i]), other = axis(parts[b].axes[i]);
          if (one == kNoAxis || other == kNoAxis || one == other) continue;
          expected.push_back(AxisTurn{0, i, from, to}.key());
        }
      }
    }
    for (const AxisTurn& turn : axis_turns(parts)) {
      found.push_back(turn.key());
      const MonotonePart& own = parts[turn.rectangle];
      const bool along_u = turn.from.y() == turn.to.y();
      EXPECT_TRUE(own.axes[turn.level] & (along_u ? kAlongU : kAlongV));
      EXPECT_TRUE(own.part.u.contains(Interval(turn.from.x(), turn.to.x())));
      EXPECT_TRUE(own.part.v.contains(Interval(turn.from.y(), turn.to.y())));
    }
    std::sort(expected.begin(), expected.end());
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
  }
}

// Of the distance from a point: wherever the point and whatever the radius, the circle crosses a
// turn, although it may pass parts that are monotone along both axes.
TEST(AxisTurns, ACircleCrossesOne) {
  test::Random random(6);
  for (int round = 0; round < 50; ++round) {
    const Vec2 c(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3));
    const double r = random.uniform(0.05, 0.6);
    const auto holds_level = [&](const ReceiverCell& w) {
      const Interval square = sqr(w.u - c.x()) + sqr(w.v - c.y());
      return square.contains(r * r);
    };
    const auto axes = [&](const ReceiverCell& w) {
      return Axes((w.u.contains(c.x()) ? kNoAxis : kAlongU) |
                  (w.v.contains(c.y()) ? kNoAxis : kAlongV));
    };
    std::vector<MonotonePart> parts;
    for (const ReceiverCell& part :
         subdivision({{-1.0, 1.0}, {-1.0, 1.0}},
                     [&](const ReceiverCell& w) { return holds_level(w) && axes(w) == kNoAxis; })) {
      parts.push_back({part, {holds_level(part) ? axes(part) : kNoAxis}});
    }
    const auto turns = axis_turns(parts);
    EXPECT_TRUE(std::any_of(turns.begin(), turns.end(), [&](const AxisTurn& turn) {
      return ((turn.from - c).norm() - r) * ((turn.to - c).norm() - r) <= 0.0;
    }));
  }
}

}  // namespace
}  // namespace caustic::solver
