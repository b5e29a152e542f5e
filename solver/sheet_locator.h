// All sheets of an explored field at a point of the receiver: the cells whose images may cover it,
// then Newton's method in each (S51).
#pragma once

#include <vector>

#include "solver/family_field.h"

namespace caustic::solver {

class SheetLocator {
 public:
  /// The field must outlive it.
  explicit SheetLocator(const FamilyField& field);

  /// Lit points of the first surface inside the domain whose paths arrive at q.
  std::vector<FieldPoint> at(const Vec2& q, Evaluator& evaluate) const;

 private:
  struct Image {  // of a cell, widened
    Vec2 lo, hi;
    bool folded;  ///< a changes its sign, so that there may be two places
  };
  std::size_t bin(const Vec2& q, int axis) const;

  const FamilyField& field_;
  std::vector<Image> images_;
  std::vector<std::vector<int>> bins_;  // cells by a grid over the receiver
};

}  // namespace caustic::solver
