#include "solver/axis_turns.h"

#include <algorithm>
#include <map>

namespace caustic::solver {

namespace {

// Rectangles that end and that begin at one coordinate.
struct Line {
  std::vector<int> before, behind;
};

// Of two axes one is chosen, so that parts with a choice hang together.
Axes chosen(Axes axes) { return axes & kAlongU ? kAlongU : axes; }

}  // namespace

std::vector<AxisTurn> axis_turns(const std::vector<MonotonePart>& parts) {
  std::vector<AxisTurn> turns;
  for (const Axes along : {kAlongU, kAlongV}) {
    const auto run = [&](int i) { return along == kAlongU ? parts[i].part.u : parts[i].part.v; };
    const auto across = [&](int i) { return along == kAlongU ? parts[i].part.v : parts[i].part.u; };
    std::map<double, Line> lines;
    for (int i = 0; i < static_cast<int>(parts.size()); ++i) {
      lines[across(i).hi].before.push_back(i);
      lines[across(i).lo].behind.push_back(i);
    }
    const auto meet_at = [&](double w, int a, int b) {
      const double low = std::max(run(a).lo, run(b).lo), high = std::min(run(a).hi, run(b).hi);
      for (int level = 0; low < high && level < static_cast<int>(parts[a].axes.size()); ++level) {
        const Axes of_a = chosen(parts[a].axes[level]), of_b = chosen(parts[b].axes[level]);
        if (of_a == of_b || of_a == kNoAxis || of_b == kNoAxis) continue;
        AxisTurn turn{of_a == along ? a : b, level, {low, w}, {high, w}};
        if (along == kAlongV) turn.from = {w, low}, turn.to = {w, high};
        turns.push_back(turn);
      }
    };
    for (auto& [w, line] : lines) {
      const auto earlier = [&](int a, int b) { return run(a).lo < run(b).lo; };
      std::sort(line.before.begin(), line.before.end(), earlier);
      std::sort(line.behind.begin(), line.behind.end(), earlier);
      for (std::size_t i = 0, j = 0; i < line.before.size() && j < line.behind.size();) {
        const int a = line.before[i], b = line.behind[j];
        meet_at(w, a, b);
        run(a).hi < run(b).hi ? ++i : ++j;
      }
    }
  }
  return turns;
}

}  // namespace caustic::solver
