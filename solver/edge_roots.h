// Where a level crosses an edge along which a total is monotone: once at most. NOTATION.md (S79).
#pragma once

#include <optional>
#include <vector>

#include "solver/branches.h"
#include "solver/mirror_cells.h"
#include "solver/rectangle_totals.h"

namespace caustic::solver {

/// A place on an arc of the total.
struct TotalSeed {
  int level;  ///< index
  Vec2 q;
  Branches branches;
};

class EdgeRoots {
 public:
  /// `mirrors` are those of the fields that `carrier` carries. `levels` in W/m².
  EdgeRoots(SheetCarrier& carrier, std::vector<MirrorCells>& mirrors,
            const std::vector<double>& levels)
      : carrier_(carrier), mirrors_(mirrors), levels_(levels) {}

  /// Adds to `seeds` the place between two corners of a rectangle's edges where `sum`, a total that
  /// is monotone there, has the level, if it has and is the total there. False if that cannot be
  /// told, for there may be caustics in between.
  bool find(const Vec2& from, const Vec2& to, RectangleTotals& over, const PossibleTotal& sum,
            int level, std::vector<TotalSeed>& seeds);

 private:
  // The total at one end of an edge.
  struct End {
    bool known = false;
    unsigned near = 0;  // neighbourhoods of caustics that something of it comes from
    Branches branches;
    double E = 0.0;
  };
  End end_at(const Vec2& q, RectangleTotals& over, const PossibleTotal& sum);
  const std::optional<Branches>& near_at(const Vec2& q, FieldNear& near);
  std::optional<Branches> find_near(const Vec2& q, const FieldNear& near);
  std::optional<Branch> branch_of(int field, const EnclosedSheet& sheet, const Vec2& q);
  bool add_root(const End& a, const Vec2& from, const End& b, const Vec2& to, int level,
                std::vector<TotalSeed>& seeds);
  bool is_the_total(const Branches& branches, const Vec2& q);
  bool is_among(const Branches& branches, const Branch& b) const;

  SheetCarrier& carrier_;
  std::vector<MirrorCells>& mirrors_;
  const std::vector<double>& levels_;
};

}  // namespace caustic::solver
