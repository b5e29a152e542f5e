#include "geometry/expression/leaves.h"

#include <algorithm>
#include <cmath>
#include <deque>

namespace caustic::geometry {

namespace {

/// A box whose sides are this share of the bounds' is not halved: a piece of surface that turns
/// through all directions within is lost.
constexpr double kSmallestShare = 0x1p-16;
/// Boxes looked at in all. A surface that is singular along all of itself would take any number.
constexpr int kMostBoxes = 10000;
/// A graph that may be steeper than this is cut: another axis may suit better, and a chart's area
/// should not vary without bound.
constexpr double kSteepest = 20.0;
/// Boxes are not cut in their middles, where a symmetric surface may lie in the cut and be counted
/// on both of its sides.
constexpr double kCut[3] = {0.4971, 0.5037, 0.4913};

/// Mean value form about the box's centre (S17): narrower than the natural one on small boxes.
Interval mean_value(const Field& field, const Box& box, const IntervalVec3& gradient) {
  const Point c = box.center();
  Interval g;
  field.enclose(intervals(c), g);
  const IntervalVec3 d = intervals(box) - c;
  for (int k = 0; k < 3; ++k) g += gradient[k] * d[k];
  return g;
}

struct Test {
  bool defined, somewhere;  // on all of the box; on a part of it
  bool zero;                // perhaps
  IntervalVec3 gradient;
};

Test test(const Field& field, const Box& box) {
  Test t;
  Interval g;
  t.defined = field.enclose(intervals(box), g, t.gradient);
  t.somewhere = !g.empty();
  t.zero = g.contains_zero();
  if (t.zero && t.defined) t.zero = mean_value(field, box, t.gradient).contains_zero();
  return t;
}

// The axis along which the surface is a graph, the flattest one if there are several; or −1.
int axis_of_graph(const IntervalVec3& gradient) {
  int axis = -1;
  for (int k = 0; k < 3; ++k) {
    const double least = gradient[k].mignitude();
    if (least > 0.0 && (axis < 0 || least > gradient[axis].mignitude())) axis = k;
  }
  return axis;
}

// Slope of the graph over the other two coordinates, at most.
double steepness(const IntervalVec3& gradient, int axis) {
  const double across =
      std::hypot(gradient[(axis + 1) % 3].magnitude(), gradient[(axis + 2) % 3].magnitude());
  return across / gradient[axis].mignitude();
}

// Between two opposite sides on which a monotone field has the same sign there is no zero.
bool crosses(const Field& field, const Leaf& leaf, const IntervalVec3& gradient) {
  Interval g[2];
  for (const int side : {0, 1}) {
    Box face = leaf.box;
    (side == 0 ? face.max : face.min)[leaf.axis] = (side == 0 ? face.min : face.max)[leaf.axis];
    g[side] = mean_value(field, face, gradient);
  }
  return !((g[0].lo > 0.0 && g[1].lo > 0.0) || (g[0].hi < 0.0 && g[1].hi < 0.0));
}

// The axis along which ∇g varies most over the box, −1 if the box is too small to be cut: what does
// not bend the surface need not be cut.
int axis_to_cut(const Field& field, const Box& box, const Vec3& whole) {
  SurfaceEnclosure e;
  const bool defined = field.enclose(intervals(box), e);
  const Vec3 size = box.max - box.min;
  int axis = -1;
  double most = -1.0;
  for (int k = 0; k < 3; ++k) {
    const double share = size[k] / whole[k];
    if (share < kSmallestShare) continue;
    double bend = 0.0;
    for (int i = 0; i < 6; ++i) {
      const auto [row, column] = kPackedIndices[i];
      if (row == k || column == k) bend = std::max(bend, e.hessian[i].magnitude() * size[k]);
    }
    const double weight = defined && std::isfinite(bend) ? bend : share;
    if (weight > most) {
      axis = k;
      most = weight;
    }
  }
  return axis;
}

// Slices without zero at the six sides are cut off.
Box trimmed(const Field& field, Box box) {
  for (int k = 0; k < 3; ++k) {
    for (const bool low : {true, false}) {
      for (const double share : {0.5, 0.25, 0.125}) {
        const double cut = low ? box.min[k] + share * (box.max[k] - box.min[k])
                               : box.max[k] - share * (box.max[k] - box.min[k]);
        Box slice = box;
        (low ? slice.max : slice.min)[k] = cut;
        Interval g;
        field.enclose(intervals(slice), g);
        if (!g.contains_zero()) (low ? box.min : box.max)[k] = cut;
      }
    }
  }
  return box;
}

}  // namespace

Leaves cut_into_graphs(const Field& field, const Box& bounds) {
  Leaves leaves;
  const Vec3 size = bounds.max - bounds.min;
  // Breadth first: where the budget ends, it ends at one depth everywhere.
  std::deque<Box> queue{bounds};
  for (int seen = 0; !queue.empty(); ++seen) {
    const Box box = trimmed(field, queue.front());
    queue.pop_front();
    const Test t = test(field, box);
    leaves.defined_somewhere |= t.somewhere;
    if (!t.zero) continue;
    const int k = axis_to_cut(field, box, size);
    const bool last = seen >= kMostBoxes || k < 0;
    const Leaf leaf{box, t.defined ? axis_of_graph(t.gradient) : -1};
    if (leaf.axis >= 0) {
      if (!crosses(field, leaf, t.gradient)) continue;
      if (last || steepness(t.gradient, leaf.axis) <= kSteepest) {
        leaves.graphs.push_back(leaf);
        continue;
      }
    }
    if (last) {
      leaves.undecided.push_back(box);
      continue;
    }
    const double cut = box.min[k] + kCut[k] * (box.max[k] - box.min[k]);
    queue.push_back(box);
    queue.back().max[k] = cut;
    queue.push_back(box);
    queue.back().min[k] = cut;
  }
  return leaves;
}

namespace {

// The field along the leaf's axis at (s, t), and its values at the two ends.
struct Column {
  const Field& field;
  int axis;
  Point x;
  double lo, hi, g_lo, g_hi;

  Column(const Field& f, const Leaf& leaf, double s, double t)
      : field(f), axis(leaf.axis), lo(leaf.box.min[axis]), hi(leaf.box.max[axis]) {
    const Vec3 size = leaf.box.max - leaf.box.min;
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    x[i] = leaf.box.min[i] + s * size[i];
    x[j] = leaf.box.min[j] + t * size[j];
    g_lo = value(lo);
    g_hi = value(hi);
  }
  double value(double w) {
    x[axis] = w;
    return field.value(x);
  }
  double slope(double w) {
    x[axis] = w;
    Vec3 gradient;
    field.value_gradient(x, gradient);
    return gradient[axis];
  }
  bool has_root() const { return std::min(g_lo, g_hi) <= 0.0 && std::max(g_lo, g_hi) >= 0.0; }

  // Newton's step from the end that is nearer to the zero, drawn in to less than the leaf's height.
  double beyond() {
    const bool low = std::abs(g_lo) < std::abs(g_hi);
    const double end = low ? lo : hi, height = hi - lo;
    const double step = -(low ? g_lo : g_hi) / slope(end);
    return end + step / (1.0 + std::abs(step) / height);
  }
};

}  // namespace

bool graph_exists(const Field& field, const Leaf& leaf, double s, double t) {
  return Column(field, leaf, s, t).has_root();
}

Point graph_point(const Field& field, const Leaf& leaf, double s, double t) {
  Column column(field, leaf, s, t);
  double root;
  if (column.g_lo == 0.0) {
    root = column.lo;
  } else if (column.g_hi == 0.0) {
    root = column.hi;
  } else if ((column.g_lo > 0.0) == (column.g_hi > 0.0)) {
    root = column.beyond();
  } else {
    root = bracketed_root([&](double w) { return column.value(w); },
                          [&](double w) { return column.slope(w); }, column.lo, column.hi,
                          column.g_lo);
  }
  column.x[leaf.axis] = root;
  return column.x;
}

}  // namespace caustic::geometry
