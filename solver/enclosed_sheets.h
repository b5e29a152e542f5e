// All sheets of a family over a rectangle of the receiver, each proven to be there and to be one,
// with its irradiance enclosed. NOTATION.md (S77), (S78).
#pragma once

#include <optional>
#include <vector>

#include "solver/evaluator.h"
#include "solver/mirror_cells.h"

namespace caustic::solver {

/// One preimage of each place of a rectangle, in a chart of its own.
struct EnclosedSheet {
  geometry::GraphChart chart;
  GraphCell cell;                ///< holds the preimages of the whole rectangle
  geometry::IntervalVec3 alone;  ///< holds no other preimages of it
  bool certain = false;  ///< inside the domain all over; else in a part of the rectangle at most
  bool nowhere = false;  ///< outside of it all over
  bool clear = true;     ///< nothing hides its light
  Interval E, E_u, E_v;  ///< W/m², W/m³, receiver axes
};

/// Cells next to a caustic: it is not told how many sheets a place of the rectangle has from there,
/// but of each of them this (S78).
struct NearCaustic {
  std::vector<int> cells;
  bool folds;    ///< A may vanish
  bool inside;   ///< of the domain all over
  bool clear;    ///< nothing hides its light
  double least;  ///< irradiance, W/m²
  std::array<MirrorCell::Steep, 2> steep;

  /// Along an axis it grows, or falls, on all sheets.
  bool grows() const { return steep[0].sign != 0 || steep[1].sign != 0; }
  /// Smaller cells would hardly tell more.
  bool told() const { return folds && inside && clear && grows(); }
};

struct EnclosedSheets {
  std::vector<EnclosedSheet> sheets;
  std::vector<NearCaustic> near;
};

/// Nothing if it cannot be told for a rectangle of this size, m, or the budget is exhausted.
/// `cells` hold all that reach it.
std::optional<EnclosedSheets> sheets_over(const ReceiverCell& part, MirrorCells& mirror,
                                          std::vector<int> cells, double size, Evaluator& evaluate);

/// The place on the same side of all caustics that sends light to q, within `tolerance` of it, m,
/// by Newton's method; nothing if that does not converge.
std::optional<FieldPoint> preimage(Evaluator& evaluate, const FieldPoint& from, const Vec2& q,
                                   double tolerance);

/// The same sheet over a part of its rectangle; false if enclosures do not show it.
bool narrow_sheet(const EnclosedMap& map, const ReceiverCell& part, EnclosedSheet& sheet);

}  // namespace caustic::solver
