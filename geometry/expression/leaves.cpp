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
  leaves.graphs = merged(field, leaves);
  return leaves;
}

namespace {

// A step of this share of the leaf's height is the last one: what is left is of the order of its
// cube.
constexpr double kLastStep = 1e-6;
constexpr int kMostSteps = 200;
// Where Halley's method would change Newton's step by more than this share, that is taken.
constexpr double kMostBent = 0.5;

// Moves x along the leaf's axis to the zero of the field, which is monotone there: Halley's method
// kept in a bracket. The leaf's ends are looked at only if a step leads beyond; where the zero
// does, false.
bool move_to_zero(const Field& field, const Leaf& leaf, Point& x) {
  const int k = leaf.axis;
  double& w = x[k];
  const double least = leaf.box.min[k], most = leaf.box.max[k], height = most - least;
  double bracket[2] = {least, most};
  bool seen[2] = {false, false};  // the ends of the bracket
  double last_step = 2.0 * height;
  w = 0.5 * (least + most);
  for (int i = 0; i < kMostSteps; ++i) {
    const auto [g, slope, bend] = field.along_axis(x, k);
    if (g == 0.0) return true;
    const double newton = -g / slope;
    const int ahead = newton > 0.0 ? 1 : 0;
    if (ahead == 0 ? w <= least : w >= most) {
      w += newton / (1.0 + std::abs(newton) / height);
      return false;
    }
    bracket[1 - ahead] = w;
    seen[1 - ahead] = true;
    const double bent = 0.5 * newton * bend / slope;
    double step = std::abs(bent) <= kMostBent ? newton / (1.0 + bent) : newton;
    const bool within = w + step > bracket[0] && w + step < bracket[1];
    if (within && std::abs(step) <= kLastStep * height) {
      w += step;
      return true;
    }
    const bool goes_well = within && std::abs(step) <= 0.5 * last_step;
    last_step = std::abs(step);
    if (goes_well) {
      w += step;
    } else if (!seen[ahead]) {
      w = bracket[ahead];
    } else {
      // After a halving the method may go where it wants in the bracket.
      last_step = 2.0 * height;
      const double middle = 0.5 * (bracket[0] + bracket[1]);
      if (middle == bracket[0] || middle == bracket[1]) return true;
      w = middle;
    }
  }
  return true;
}

// The place over (s, t) in the leaf's rectangle; along the axis anywhere.
Point over(const Leaf& leaf, double s, double t) {
  const Vec3 size = leaf.box.max - leaf.box.min;
  const int i = (leaf.axis + 1) % 3, j = (leaf.axis + 2) % 3;
  Point x = leaf.box.min;
  x[i] += s * size[i];
  x[j] += t * size[j];
  return x;
}

}  // namespace

bool graph_exists(const Field& field, const Leaf& leaf, double s, double t) {
  Point x = over(leaf, s, t);
  return move_to_zero(field, leaf, x);
}

Point graph_point(const Field& field, const Leaf& leaf, double s, double t) {
  Point x = over(leaf, s, t);
  move_to_zero(field, leaf, x);
  return x;
}

}  // namespace caustic::geometry
