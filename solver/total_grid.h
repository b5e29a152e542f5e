// A grid of totals on the receiver that finds what tracing from the boundaries cannot: closed arcs
// inside a face. Where the totals at two neighbours say that a level lies between, an odd number of
// arcs must pass between them (S55). Neighbours are also each maximum and minimum that is found
// from the grid and from the critical points of sheets, and the node next to it (S66): an arc about
// one of these is found however small it is.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "solver/branches.h"

namespace caustic::solver {

class TotalGrid {
 public:
  explicit TotalGrid(SheetCarrier& carrier);

  /// Seeks a maximum or a minimum from here too, before the first level: in a face that is too
  /// small for the grid.
  void look_from(const Vec2& q) { add_spoke(q, carrier_.find(q)); }
  /// What is less wide or less high than this may lie between its nodes, m.
  double blind_below() const { return (place(2, 2) - place(0, 0)).maxCoeff(); }

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
  /// From an extreme of the total to a node.
  struct Spoke {
    Node extreme, end;
    Vec2 from, to;
    std::vector<double> passed = {};  ///< shares at which arcs pass it
    bool unsure = false, given_up = false;
  };
  std::size_t index(int i, int j) const { return static_cast<std::size_t>(j * (count_ + 1) + i); }
  Vec2 place(int i, int j) const;
  void find_spokes();
  void add_spoke(const Vec2& from, const Branches& branches);
  void add_to_spokes(const Vec2& a, const Vec2& b, double distance);
  std::optional<Place> missing_on(Spoke& spoke);
  void doubt_nodes_near(const Vec2& a, const Vec2& b, double distance);
  std::optional<Place> level_on_edge(const Node& a, const Vec2& qa, const Node& b, const Vec2& qb,
                                     std::vector<double> passed);
  Node node_at(const Vec2& q);
  bool complete(std::size_t a, const Vec2& qa, std::size_t b, const Vec2& qb);
  std::optional<Place> level_between(Node a, Vec2 qa, Node b, Vec2 qb);
  std::optional<Place> level_in_face(const Node& a, const Vec2& qa, const Node& b, const Vec2& qb);

  SheetCarrier& carrier_;
  Vec2 half_;
  int count_;
  std::vector<Node> nodes_;
  std::vector<Spoke> spokes_;
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
