// The sheets that reach one point of the receiver, carried along as the point moves (S50).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "solver/sheet_locator.h"

namespace caustic::solver {

/// One path to a point of the receiver.
struct Branch {
  int field;      ///< index of its family's field
  FieldPoint at;  ///< on the first surface
};
using Branches = std::vector<Branch>;

/// Sum over branches: E in W/m², ∇E in receiver axes, W/m³.
struct Total {
  double E = 0.0;
  Vec2 gradient = Vec2::Zero();
};
Total total_of(const Branches& branches);

/// The fields of a request with what it takes to move on them. Not thread-safe.
class SheetCarrier {
 public:
  /// `fields` are explored, of families of one hop; they must outlive it.
  SheetCarrier(const OpticalSystem& system, std::vector<const FamilyField*> fields, Budget& budget);

  const FamilyField& field(int i) const { return *fields_[i]; }
  int field_count() const { return static_cast<int>(fields_.size()); }
  Evaluator& evaluator(int field) { return *evaluators_[field]; }
  const OpticalSystem& system() const { return system_; }

  /// The path of the same sheet to another point of the receiver; nothing if a fold or the end of
  /// the family's domain of definition is in between.
  std::optional<FieldPoint> carry(int field, const FieldPoint& from, const Vec2& to);
  /// Carries all, or leaves them as they are and returns false.
  bool carry(Branches& branches, const Vec2& to);

  /// What is remembered of other paths' room (S13), which is an estimate, may do, or not.
  enum class Look { remembered, anew };
  /// True if something hides the path at this point.
  bool hidden(int field, const FieldPoint& at, Look look = Look::remembered);

  /// All paths to q that nothing hides, found anew; none once the budget is exhausted.
  Branches find(const Vec2& q, Look look = Look::remembered);

 private:
  std::optional<FieldPoint> newton(int field, const FieldPoint& from, const Vec2& to);

  const OpticalSystem& system_;
  std::vector<const FamilyField*> fields_;
  std::vector<std::unique_ptr<Evaluator>> evaluators_;
  std::vector<SheetLocator> locators_;
  std::vector<std::optional<Lookout>> lookouts_;  // of fields of which something may be hidden
  Budget& budget_;
};

}  // namespace caustic::solver
