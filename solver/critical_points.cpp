#include "solver/critical_points.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace caustic::solver {

namespace {

constexpr int kStartsAcross = 32;  // places of the grid, a side
// Newton's method begins where its first step is no longer than so many cells of the grid, and
// roams no farther than so many.
constexpr double kFirstSettlingStep = 2.0;
constexpr double kRoam = 3.0;
constexpr int kMaxSettling = 30;
constexpr int kMaxHalvings = 6;
// In widths of the receiver: the step of differences for the Hessian, the step of Newton's method
// that ends it, and the distance at which two points are one.
constexpr double kHessianStep = 1e-5;
constexpr double kLastSettlingStep = 1e-10;
constexpr double kSamePoint = 1e-7;
// Sheets end this many roundings beyond their domain.
constexpr double kSheetEndRoundings = 100.0;
// Curvatures below this share of the other one's, or that would change E by less than this share
// over the receiver, are rounding of the differences.
constexpr double kFlatCurvature = 1e-6;
// Totals that differ by no more than this share are of the same sheets.
constexpr double kSameSheets = 1e-7;

Vec2 eigenvalues(const geometry::Mat2& H) {
  Eigen::SelfAdjointEigenSolver<geometry::Mat2> eigen;
  eigen.computeDirect(H, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues();
}

// Nothing where E has no curvature: a critical line, or an even field.
std::optional<CriticalType> type_of(const geometry::Mat2& H, double E, double half) {
  const Vec2 curvatures = eigenvalues(H), sizes = curvatures.cwiseAbs();
  if (!(sizes.minCoeff() > kFlatCurvature * std::max(sizes.maxCoeff(), E / (half * half))))
    return std::nullopt;
  if (curvatures[0] > 0.0) return CriticalType::minimum;
  return curvatures[1] < 0.0 ? CriticalType::maximum : CriticalType::saddle;
}

// (S66): Newton's step for ∇(1/E) = 0, which next to a caustic is nearly linear while E is not.
Vec2 newton_step(const Total& total, const geometry::Mat2& H) {
  const geometry::Mat2 K = 2.0 * total.gradient * total.gradient.transpose() / total.E - H;
  return K.inverse() * total.gradient;
}

// The first hit is that of the brightest sheet.
CriticalPlace place_of(const SettledPoint& settled, int family) {
  const auto brightest = std::max_element(
      settled.branches.begin(), settled.branches.end(),
      [](const Branch& a, const Branch& b) { return a.at.irradiance() < b.at.irradiance(); });
  return {settled.q, brightest->at.x, settled.total.E, settled.type, family};
}

// By place, and each once.
std::vector<CriticalPlace> distinct(std::vector<CriticalPlace> found, double near) {
  std::sort(found.begin(), found.end(), [](const CriticalPlace& a, const CriticalPlace& b) {
    return std::pair(a.uv.x(), a.uv.y()) < std::pair(b.uv.x(), b.uv.y());
  });
  std::vector<CriticalPlace> kept;
  for (const CriticalPlace& c : found) {
    const bool again = std::any_of(kept.begin(), kept.end(), [&](const CriticalPlace& k) {
      return k.family_id == c.family_id && (k.uv - c.uv).norm() <= near &&
             (k.x - c.x).norm() <= near && std::abs(k.E - c.E) <= kSameSheets * c.E;
    });
    if (!again) kept.push_back(c);
  }
  return kept;
}

}  // namespace

std::optional<geometry::Mat2> hessian_of_total(SheetCarrier& carrier, const Vec2& q,
                                               const Branches& at) {
  const double h = kHessianStep * carrier.system().receiver().width();
  geometry::Mat2 H;
  for (const int axis : {0, 1}) {
    Vec2 slopes[2];
    for (const int side : {0, 1}) {
      Branches there = at;
      Vec2 to = q;
      to[axis] += side == 0 ? -h : h;
      if (!carrier.carry(there, to)) return std::nullopt;
      slopes[side] = total_of(there).gradient;
    }
    H.col(axis) = (slopes[1] - slopes[0]) / (2.0 * h);
  }
  return geometry::Mat2(0.5 * (H + H.transpose()));
}

bool sheets_exist(const SheetCarrier& carrier, const Branches& branches) {
  return std::all_of(branches.begin(), branches.end(), [&](const Branch& b) {
    const FamilyField& field = carrier.field(b.field);
    return b.at.lit() &&
           field.domain.worst(b.at).value <= kSheetEndRoundings * field.map.rounding(b.at.x) *
                                                 (1.0 + b.at.q_s.norm() + b.at.q_t.norm());
  });
}

std::optional<SettledPoint> settle(SheetCarrier& carrier, const Vec2& from,
                                   const Branches& branches, double roam) {
  const auto& receiver = carrier.system().receiver();
  if (branches.empty()) return std::nullopt;
  Vec2 q = from;
  Branches at = branches;
  for (int i = 0; i < kMaxSettling; ++i) {
    const Total total = total_of(at);
    const auto H = hessian_of_total(carrier, q, at);
    if (!H || !(total.E > 0.0)) return std::nullopt;
    Vec2 step = newton_step(total, *H);
    if (!step.allFinite()) return std::nullopt;
    if (step.norm() <= kLastSettlingStep * receiver.width()) {
      const auto type = type_of(*H, total.E, receiver.half.norm());
      if (!type || !sheets_exist(carrier, at)) return std::nullopt;
      return SettledPoint{q, std::move(at), total, *type};
    }
    if (step.norm() > roam) step *= roam / step.norm();
    bool moved = false;
    for (int k = 0; k < kMaxHalvings && !moved; ++k, step *= 0.5) {
      if (!receiver.contains(q + step) || (q + step - from).norm() > roam) continue;
      if (!carrier.carry(at, q + step)) continue;
      q += step;
      moved = true;
    }
    if (!moved) return std::nullopt;
  }
  return std::nullopt;
}

std::vector<CriticalPlace> critical_points_of_total(SheetCarrier& carrier,
                                                    const std::vector<Vec2>& places) {
  const auto& receiver = carrier.system().receiver();
  const double cell = 2.0 * receiver.half.norm() / kStartsAcross;
  std::vector<CriticalPlace> found;
  const auto look_from = [&](const Vec2& q, bool selected) {
    const Branches branches = carrier.find(q);
    if (branches.empty()) return;
    if (!selected) {
      const auto H = hessian_of_total(carrier, q, branches);
      if (!H || !(newton_step(total_of(branches), *H).norm() <= kFirstSettlingStep * cell)) return;
    }
    const auto settled = settle(carrier, q, branches, kRoam * cell);
    if (!settled) return;
    // On the way sheets may have begun that were not carried.
    const double E = total_of(carrier.find(settled->q)).E;
    if (std::abs(E - settled->total.E) > kSameSheets * E) return;
    found.push_back(place_of(*settled, -1));
  };
  for (int j = 0; j < kStartsAcross; ++j) {
    for (int i = 0; i < kStartsAcross; ++i) {
      const Vec2 share((2.0 * i + 1.0) / kStartsAcross - 1.0,
                       (2.0 * j + 1.0) / kStartsAcross - 1.0);
      look_from(share.cwiseProduct(receiver.half), false);
    }
  }
  for (int k = 0; k < carrier.field_count(); ++k) {
    for (const CriticalPoint& c : carrier.field(k).critical) {
      if (receiver.contains(c.field.q)) look_from(c.field.q, true);
    }
  }
  for (const Vec2& q : places) look_from(q, true);
  return distinct(std::move(found), kSamePoint * receiver.width());
}

std::vector<CriticalPlace> critical_points_of_sheets(SheetCarrier& carrier) {
  const auto& receiver = carrier.system().receiver();
  std::vector<CriticalPlace> found;
  for (int k = 0; k < carrier.field_count(); ++k) {
    for (const CriticalPoint& c : carrier.field(k).critical) {
      if (!receiver.contains(c.field.q) || carrier.hidden(k, c.field)) continue;
      const double roam = kRoam / kStartsAcross * receiver.width();
      if (const auto settled = settle(carrier, c.field.q, {{k, c.field}}, roam))
        found.push_back(place_of(*settled, carrier.field(k).piece.family));
    }
  }
  return distinct(std::move(found), kSamePoint * receiver.width());
}

}  // namespace caustic::solver
