#include "solver/branches.h"

#include <cmath>

namespace caustic::solver {

namespace {

constexpr int kMaxCarrySteps = 12;
// Newton's first step must leave less than this share of the way, or the way is halved: on it the
// map is far from linear, and another sheet could be met.
constexpr double kContraction = 0.25;
constexpr double kLeastShare = 0x1p-16;
constexpr int kMaxCarries = 400;
// Arrival within this many roundings of x, by the stretch of the map.
constexpr double kArrivalRoundings = 4.0;

// Of the way and the place.
constexpr double kFineArrival = 1e-12;

}  // namespace

Total total_of(const Branches& branches) {
  Total sum;
  for (const Branch& b : branches) {
    sum.E += b.at.irradiance();
    sum.gradient += b.at.irradiance_gradient();
  }
  return sum;
}

SheetCarrier::SheetCarrier(const OpticalSystem& system, std::vector<const FamilyField*> fields,
                           Budget& budget)
    : system_(system), fields_(std::move(fields)), budget_(budget) {
  for (const FamilyField* field : fields_) {
    evaluators_.push_back(std::make_unique<Evaluator>(field->map, budget));
    locators_.emplace_back(*field);
    lookouts_.emplace_back();
    if (field->visibility) lookouts_.back().emplace(*field->visibility, field->piece.hops);
  }
}

bool SheetCarrier::hidden(int field, const FieldPoint& at, Look look) {
  const FamilyField& f = *fields_[field];
  if (!f.visibility) return false;
  const LightPath path(f.map, at);
  return look == Look::anew ? f.visibility->hidden(f.piece.hops, path)
                            : lookouts_[field]->hidden(path);
}

// (S50): x moves by J dq, J dq = M⁻¹ dq in the tangent frame, until q(x) has arrived.
std::optional<FieldPoint> SheetCarrier::newton(int field, const FieldPoint& from, const Vec2& to) {
  Evaluator& evaluate = *evaluators_[field];
  const double way = (to - from.q).norm();
  FieldPoint at = from;
  double left = way, before = geometry::kInfinity;
  for (int i = 0; i < kMaxCarrySteps; ++i) {
    const double stretch = std::sqrt(at.q_s.squaredNorm() + at.q_t.squaredNorm());
    const double rounding = evaluate.map().rounding(at.x);
    const double near = kArrivalRoundings * (stretch * rounding + geometry::kEpsilon * to.norm());
    // Where rounding may be much, not before it is met.
    if (left <= near && (near <= kFineArrival * (way + to.norm()) || left >= 0.5 * before))
      return at;
    const Vec3 step = at.pull_back(to - at.q);
    if (!step.allFinite()) return std::nullopt;
    at = evaluate.on_surface(at.x + step, at.hits.get());
    // Where it would end on the receiver itself it goes on smoothly, as across every edge.
    if (!at.finite || !(at.a * from.a > 0.0)) return std::nullopt;
    before = left;
    left = (to - at.q).norm();
    if (left <= near) continue;
    if (i == 0 && left > kContraction * way) return std::nullopt;
    // As near as rounding allows.
    if (i > 2 && left >= 0.5 * before) {
      return left <= 1e-9 * (way + to.norm()) ? std::optional(at) : std::nullopt;
    }
  }
  return std::nullopt;
}

std::optional<FieldPoint> SheetCarrier::carry(int field, const FieldPoint& from, const Vec2& to) {
  FieldPoint at = from;
  double share = 1.0;
  for (int steps = 0; steps < kMaxCarries && !budget_.exhausted(); ++steps) {
    const bool last = share == 1.0;
    if (auto next = newton(field, at, last ? to : Vec2(at.q + share * (to - at.q)))) {
      if (last) return next;
      at = std::move(*next);
      share = std::min(1.0, 2.0 * share);
    } else {
      share *= 0.5;
      if (share < kLeastShare) return std::nullopt;
    }
  }
  return std::nullopt;
}

bool SheetCarrier::carry(Branches& branches, const Vec2& to) {
  Branches moved;
  moved.reserve(branches.size());
  for (const Branch& b : branches) {
    auto at = carry(b.field, b.at, to);
    if (!at) return false;
    moved.push_back({b.field, std::move(*at)});
  }
  branches.swap(moved);
  return true;
}

Branches SheetCarrier::find(const Vec2& q, Look look) {
  Branches found;
  for (int i = 0; i < field_count() && !budget_.exhausted(); ++i) {
    for (FieldPoint& at : locators_[i].at(q, *evaluators_[i])) {
      if (!hidden(i, at, look)) found.push_back({i, std::move(at)});
    }
  }
  return found;
}

}  // namespace caustic::solver
