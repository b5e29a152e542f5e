// Cells of a first surface, divided by need, each with an enclosure of where it sends its light:
// those that can reach a part of the receiver. NOTATION.md (S77).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "solver/budget.h"
#include "solver/clear_way.h"
#include "solver/enclosed_map.h"

namespace caustic::solver {

/// A rectangle on the receiver, receiver axes, m.
struct ReceiverCell {
  Interval u, v;
  double size() const { return std::max(u.width(), v.width()); }
};

struct MirrorCell {
  int chart;
  GraphCell cell;
  bool regular = false;            ///< all below is enclosed
  geometry::IntervalVec3 leaving;  ///< directions in which its light goes on, of no length
  ReceiverCell image{Interval::whole(), Interval::whole()};
  bool inside = false;  ///< of the domain all over, but for the receiver's edges
  int sign = 0;         ///< of A; 0 if it has both
  double least = 0.0;   ///< irradiance of what comes from here, W/m²
  /// Of the slopes of that irradiance along u and v: no sign and 0, or their sign, the same on both
  /// sides of a caustic, and least size, W/m³ (S78).
  struct Steep {
    int sign = 0;
    double least = 0.0;
  };
  std::array<Steep, 2> steep;
  bool along_s = true;             ///< the side to be divided, that whose image is longer
  std::optional<Passage> passage;  ///< of its light, once asked for
  bool divided = false;
  std::vector<int> parts;  ///< once divided: those that may be lit
};

class MirrorCells {
 public:
  /// Nothing is asked about what hides light if that is known to be nothing. Cells are missing once
  /// the budget is exhausted.
  MirrorCells(const ForwardMap& map, bool may_be_hidden, Budget& budget);

  const EnclosedMap& map() const { return map_; }
  /// Valid until cells are divided.
  const MirrorCell& operator[](int i) const { return cells_[i]; }
  const geometry::GraphChart& chart_of(const MirrorCell& cell) const { return charts_[cell.chart]; }
  geometry::IntervalVec3 box(int i) const;
  /// True if x, but for rounding, is in one of these cells.
  bool holds(const std::vector<int>& cells, const Point& x) const;
  /// Of the light of cells.
  Passage passage(const std::vector<int>& cells);

  /// Cells that hold all that may reach all of the receiver.
  std::vector<int> all() const { return roots_; }
  /// Replaces cells by smaller ones that hold all of what may reach `part`: their images have at
  /// most this size, m, and so have they themselves where images are not enclosed. Once the budget
  /// is exhausted no more are divided: they may be larger then.
  std::vector<int> reaching(const ReceiverCell& part, const std::vector<int>& cells, double size,
                            Budget& budget);

 private:
  void add(int chart, const GraphCell& cell, std::vector<int>& to);
  Passage passage(const std::vector<int>& cells, int halvings);
  Passage passage(int i, int halvings);
  void divide(int i);
  std::array<MirrorCell::Steep, 2> steepness(int upward) const;

  EnclosedMap map_;
  ClearWay way_;
  bool may_be_hidden_;
  double least_;
  std::vector<geometry::GraphChart> charts_;
  std::vector<MirrorCell> cells_;
  std::vector<int> roots_;
  EnclosedField field_;
};

}  // namespace caustic::solver
