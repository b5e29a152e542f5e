#include "geometry/graph_cover.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>

#include "geometry/isolated_point.h"
#include "geometry/narrowed.h"

namespace caustic::geometry {

namespace {

// The first box is wider than the region by these shares of its diagonal: its faces then bound
// nothing, and no later cut runs through a plane of symmetry.
constexpr double kMarginBelow = 0.0517, kMarginAbove = 0.0733;
// A graph is no steeper than this, as long as boxes may be divided.
constexpr double kSteepestGraph = 3.0;
// Boxes smaller than this share of the first are not divided, and no more than so many looked at.
constexpr double kSmallestBoxShare = 1e-5;
constexpr std::size_t kMaxBoxes = 20000;

IntervalVec3 extended(const IntervalVec3& box, std::size_t axis) {
  IntervalVec3 longer = box;
  const double length = box[axis].width();
  longer[axis] = {box[axis].lo - length, box[axis].hi + length};
  return longer;
}

// The axis along which g is monotone, also well beyond the box, and by how much the graph rises.
struct Monotone {
  int axis;
  double slope;
};
std::optional<Monotone> flattest(const Surface& surface, const IntervalVec3& box) {
  std::optional<Monotone> best;
  for (std::size_t k = 0; k < 3; ++k) {
    const IntervalVec3 gradient = narrowed(surface, extended(box, k)).gradient;
    const double least = gradient[k].mignitude();
    const double most =
        std::max(gradient[(k + 1) % 3].magnitude(), gradient[(k + 2) % 3].magnitude());
    if (!(least > 0.0) || !std::isfinite(most)) continue;
    if (!best || most / least < best->slope) best = Monotone{static_cast<int>(k), most / least};
  }
  return best;
}

}  // namespace

GraphCover cover_by_graphs(const Surface& surface, const std::vector<Bound>& bounds,
                           const Box& region, const std::function<bool()>& stop) {
  GraphCover cover;
  const double size = region.diagonal();
  std::deque<Box> queue{
      {region.min.array() - kMarginBelow * size, region.max.array() + kMarginAbove * size}};
  for (std::size_t seen = 0; !queue.empty(); ++seen) {
    if (stop && stop()) {
      cover.undecided.insert(cover.undecided.end(), queue.begin(), queue.end());
      break;
    }
    const Box box = queue.front();
    queue.pop_front();
    const IntervalVec3 ranges = intervals(box);
    if (!narrowed(surface, ranges).g.contains_zero()) continue;
    const bool excluded = std::any_of(bounds.begin(), bounds.end(),
                                      [&](const Bound& b) { return b.least_in(box) > 0.0; });
    if (excluded) continue;
    int widest = 0;
    const double width = (box.max - box.min).maxCoeff(&widest);
    const bool last = width <= kSmallestBoxShare * size || seen >= kMaxBoxes;
    const auto graph = flattest(surface, ranges);
    if (graph && (graph->slope <= kSteepestGraph || last)) {
      const auto k = static_cast<std::size_t>(graph->axis);
      cover.charts.push_back({graph->axis, ranges, extended(ranges, k)[k]});
    } else if (last) {
      if (!holds_only_a_point(surface.enclose(ranges))) cover.undecided.push_back(box);
    } else {
      Box low = box, high = box;
      low.max[widest] = high.min[widest] = box.center()[widest];
      queue.insert(queue.end(), {low, high});
    }
  }
  return cover;
}

}  // namespace caustic::geometry
