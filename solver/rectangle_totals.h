// The totals that a rectangle of the receiver may have: which sheets and neighbourhoods of caustics
// can reach it, and what is known of each of their sums. NOTATION.md (S79).
#pragma once

#include <optional>
#include <vector>

#include "solver/branches.h"
#include "solver/enclosed_sheets.h"

namespace caustic::solver {

/// Directions along which something grows or falls all over a rectangle; bits.
enum Axes : unsigned { kNoAxis = 0, kAlongU = 1, kAlongV = 2, kBothAxes = 3 };

/// One sheet of a field.
struct FieldSheet {
  int field;
  EnclosedSheet over;
};

/// What comes to the rectangle from next to a caustic of a field.
struct FieldNear {
  int field;
  NearCaustic over;
  /// What comes from there to a place, once asked for.
  struct Corner {
    Vec2 q;
    std::optional<Branches> branches;
  };
  std::vector<Corner> corners;
};

/// Some of the sheets and some of the neighbourhoods.
struct PossibleTotal {
  std::vector<const FieldSheet*> sheets;
  unsigned near = 0;                    ///< bits: of these one sheet at least
  Interval E{0.0}, slope[2]{0.0, 0.0};  ///< W/m², W/m³ along u and v

  void add(const FieldSheet& sheet);
  void add(const NearCaustic& next, unsigned bit);
  Axes monotone() const;
};

/// All that may reach a rectangle.
struct RectangleTotals {
  std::vector<FieldSheet> certain;  ///< reach all of it
  std::vector<FieldSheet> partial;  ///< some of it at most
  std::vector<FieldNear> near;
  bool clear = true;  ///< nothing hides any of it

  std::size_t optional() const { return partial.size() + near.size(); }
  /// Calls visit(const PossibleTotal&) for each.
  template <typename Visit>
  void each(const Visit& visit) const;
};

template <typename Visit>
void RectangleTotals::each(const Visit& visit) const {
  for (unsigned chosen = 0; chosen < 1u << optional(); ++chosen) {
    PossibleTotal sum;
    for (const FieldSheet& sheet : certain) sum.add(sheet);
    for (std::size_t k = 0; k < optional(); ++k) {
      if (!(chosen >> k & 1u)) continue;
      if (k < partial.size()) {
        sum.add(partial[k]);
      } else {
        const std::size_t n = k - partial.size();
        sum.add(near[n].over, 1u << n);
      }
    }
    visit(sum);
  }
}

}  // namespace caustic::solver
