// A grid of totals on the receiver that finds what tracing from the boundaries cannot: closed arcs
// inside a face. Where the totals at two neighbours say that a level lies between, an odd number of
// arcs must pass between them (S55).
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "solver/branches.h"

namespace caustic::solver {

class TotalGrid {
 public:
  explicit TotalGrid(SheetCarrier& carrier);

  /// Begins a new level: nothing has been traced.
  void begin(double level);
  /// An arc or a jump of this level, and how far it may be from its polyline.
  void add(const std::vector<Vec2>& polyline, bool closed, double chord);

  struct Place {
    Vec2 q;
    Branches branches;
  };
  /// A place on an arc that has not been added yet, to a share of a cell; nothing if there is none
  /// left that can be found. Edges that led to nothing are counted as undecided.
  std::optional<Place> missing();
  std::size_t undecided() const { return undecided_; }

 private:
  struct Node {
    Branches branches;
    double total;
  };
  std::size_t index(int i, int j) const { return static_cast<std::size_t>(j * (count_ + 1) + i); }
  Vec2 place(int i, int j) const;
  void doubt_nodes_near(const Vec2& a, const Vec2& b, double distance);
  std::optional<Place> level_on_edge(const Node& a, const Vec2& qa, const Node& b, const Vec2& qb,
                                     std::vector<double> passed);
  Node node_at(const Vec2& q);
  std::optional<Place> level_between(Node a, Vec2 qa, Node b, Vec2 qb);
  std::optional<Place> level_in_face(const Node& a, const Vec2& qa, const Node& b, const Vec2& qb);

  SheetCarrier& carrier_;
  Vec2 half_;
  int count_;
  std::vector<Node> nodes_;
  double level_ = 0.0;
  double chord_ = 0.0;
  // Shares at which arcs pass the edge to the right of a node, and the one above it.
  std::vector<std::vector<double>> right_, above_;
  std::vector<char>
      unsure_;  // nodes so near to an arc that its polyline may pass on the other side
  std::vector<char> given_up_right_, given_up_above_;
  std::size_t undecided_ = 0;
};

}  // namespace caustic::solver
