// Pairs of neighbouring places of a family's first surface of which one is seen and one is hidden:
// an edge of what hides lies between (S57).
#pragma once

#include <optional>
#include <vector>

#include "solver/branches.h"

namespace caustic::solver {

struct Bracket {
  FieldPoint visible, hidden;
  double reach;  ///< how far edges go there, about, m
};

/// Appends what it finds.
class BracketSearch {
 public:
  /// The field must have a visibility.
  BracketSearch(SheetCarrier& carrier, int field)
      : carrier_(carrier), field_(carrier.field(field)), evaluate_(carrier.evaluator(field)) {}

  bool hidden(const FieldPoint& f) const {
    return field_.visibility->hidden(field_.piece.hops, LightPath(field_.map, f));
  }
  /// Between samples of the exploration.
  void of_cells(Budget& budget, std::vector<Bracket>& out) const;
  /// Of the direct light: what each surface hides, however small it is, and the nearest place that
  /// is seen.
  void of_shadows(std::vector<Bracket>& out) const;
  /// On a small circle about a corner, which is met by the edges that leave it; `along` the curve,
  /// if any, on which the corner was found.
  void around(const FieldPoint& corner, double reach, const std::optional<Vec3>& along,
              std::vector<Bracket>& out) const;
  /// Of that circle, m.
  double radius() const;

 private:
  SheetCarrier& carrier_;
  const FamilyField& field_;
  Evaluator& evaluate_;
};

}  // namespace caustic::solver
