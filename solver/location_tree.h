// What may matter to a question about a point of space, kept for the questions that follow: an
// octree whose nodes hold candidates, narrowed from node to node where questions come often.
// NOTATION.md (S37).
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "geometry/linear.h"

namespace caustic::solver {

class LocationTree {
 public:
  /// `size` is that of the region which the first questions are expected in; it grows with them.
  LocationTree(std::vector<int> candidates, double size)
      : nodes_(1, Node{std::move(candidates)}), half_(size) {}

  /// What may matter at p. `narrow(list, centre, radius)` leaves of a list what may matter anywhere
  /// in that ball. Valid until the next question.
  template <class Narrow>
  const std::vector<int>& at(const geometry::Point& p, const Narrow& narrow) {
    enclose(p);
    geometry::Point centre = centre_;
    double half = half_;
    int node = 0;
    for (int depth = 0; depth < kDeepest && divided(node); ++depth) {
      half *= 0.5;
      int octant = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const bool upper = p[axis] > centre[axis];
        octant |= upper << axis;
        centre[axis] += upper ? half : -half;
      }
      const int child = nodes_[node].children + octant;
      if (!nodes_[child].narrowed) {
        // The ball about the cube, and what rounding moves p out of it.
        const double radius = kAround * half;
        nodes_[child].candidates = narrow(nodes_[node].candidates, centre, radius);
        nodes_[child].narrowed = true;
      }
      node = child;
    }
    return nodes_[node].candidates;
  }

 private:
  // A node is worth its eight children once so many questions have come to it.
  static constexpr int kQuestions = 4;
  static constexpr int kDeepest = 12;
  static constexpr double kAround = 1.7321;  // √3, with room for rounding

  struct Node {
    std::vector<int> candidates;
    int children = -1;
    int asked = 0;
    bool narrowed = true;
  };

  bool divided(int node) {
    if (nodes_[node].children >= 0) return true;
    if (nodes_[node].candidates.empty()) return false;
    if (++nodes_[node].asked <= kQuestions) return false;
    nodes_[node].children = static_cast<int>(nodes_.size());
    Node child;
    child.narrowed = false;
    nodes_.resize(nodes_.size() + 8, child);
    return true;
  }

  // The root is a cube about the first question; one outside of it starts anew in a larger cube.
  void enclose(const geometry::Point& p) {
    if (!placed_) centre_ = p;
    placed_ = true;
    const double needed = (p - centre_).cwiseAbs().maxCoeff();
    if (!(needed > half_)) return;
    while (half_ < needed) half_ *= 2.0;
    nodes_.resize(1);
    nodes_[0].children = -1;
    nodes_[0].asked = 0;
  }

  std::vector<Node> nodes_;
  geometry::Point centre_ = geometry::Point::Zero();
  double half_;
  bool placed_ = false;
};

}  // namespace caustic::solver
