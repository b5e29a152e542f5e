#include "solver/edge_roots.h"

#include <algorithm>
#include <cmath>

#include "solver/enclosed_sheets.h"

namespace caustic::solver {

namespace {

// Around a corner cells are divided so often, each time to this share, to tell its sheets apart.
constexpr int kCornerRounds = 4;
constexpr double kCornerCells = 0.25;
// A root on an edge is located to this share of the level or of the edge.
constexpr double kArcRoot = 1e-10;
constexpr double kShortestBracket = 1e-12;
constexpr double kOnLevel = 1e-6;  // where rounding does not let it come nearer
// Roots up to so many roundings outside the domain lie on its boundary.
constexpr double kOffBoundary = 1e3;
// First hits this near to each other, in diameters of the scene, are of one sheet.
constexpr double kSamePlace = 1e-8;
// Paths arrive within this, in widths of the receiver.
constexpr double kOnPlace = 1e-12;

}  // namespace

// The sheet's path to q; nothing if it is not found in the box that holds it.
std::optional<Branch> EdgeRoots::branch_of(int field, const EnclosedSheet& sheet, const Vec2& q) {
  Evaluator& evaluate = carrier_.evaluator(field);
  Point x;
  x[sheet.chart.along()] = sheet.cell.z.middle();
  x[sheet.chart.first()] = sheet.cell.s.middle();
  x[sheet.chart.second()] = sheet.cell.t.middle();
  const FieldPoint middle = evaluate.on_surface(x);
  if (!middle.finite) return std::nullopt;
  const double rounding = evaluate.map().rounding(middle.x);
  auto at = preimage(evaluate, middle, q, kOnPlace * carrier_.system().receiver().width());
  if (!at) return std::nullopt;
  const double slack = kOffBoundary * rounding;
  const auto holds = [&](const Interval& a, double w) {
    return a.lo - slack <= w && w <= a.hi + slack;
  };
  if (!holds(sheet.cell.s, at->x[sheet.chart.first()]) ||
      !holds(sheet.cell.t, at->x[sheet.chart.second()]))
    return std::nullopt;
  return Branch{field, std::move(*at)};
}

// What comes to q from the neighbourhood of a caustic, in cells that get smaller until they tell.
std::optional<Branches> EdgeRoots::find_near(const Vec2& q, const FieldNear& near) {
  MirrorCells& mirror = mirrors_[near.field];
  const ReceiverCell at{q.x(), q.y()};
  double size = 0.0;
  for (const int i : near.over.cells) size = std::max(size, mirror[i].image.size());
  for (int round = 0; round < kCornerRounds; ++round) {
    size *= kCornerCells;
    const auto over =
        sheets_over(at, mirror, near.over.cells, size, carrier_.evaluator(near.field));
    if (!over || !over->near.empty()) continue;
    Branches branches;
    for (const EnclosedSheet& sheet : over->sheets) {
      auto branch = branch_of(near.field, sheet, q);
      if (!branch) return std::nullopt;
      if (!mirror.holds(near.over.cells, branch->at.x)) continue;  // a neighbour's
      branches.push_back(std::move(*branch));
    }
    return branches;
  }
  return std::nullopt;
}

const std::optional<Branches>& EdgeRoots::near_at(const Vec2& q, FieldNear& near) {
  for (const FieldNear::Corner& corner : near.corners) {
    if (corner.q == q) return corner.branches;
  }
  near.corners.push_back({q, find_near(q, near)});
  return near.corners.back().branches;
}

bool EdgeRoots::is_among(const Branches& branches, const Branch& b) const {
  const double slack = kSamePlace * carrier_.system().diameter();
  return std::any_of(branches.begin(), branches.end(), [&](const Branch& other) {
    return other.field == b.field && (other.at.x - b.at.x).norm() <= slack;
  });
}

EdgeRoots::End EdgeRoots::end_at(const Vec2& q, RectangleTotals& over, const PossibleTotal& sum) {
  End end;
  for (const FieldSheet* sheet : sum.sheets) {
    auto branch = branch_of(sheet->field, sheet->over, q);
    if (!branch) return end;
    end.branches.push_back(std::move(*branch));
  }
  for (std::size_t k = 0; k < over.near.size() && sum.near; ++k) {
    const auto& branches = near_at(q, over.near[k]);
    if (!branches) return end;
    for (const Branch& b : *branches) {
      if (is_among(end.branches, b)) continue;  // found by another cluster
      end.near |= 1u << k;
      end.branches.push_back(b);
    }
  }
  end.known = true;
  end.E = total_of(end.branches).E;
  return end;
}

// True if these sheets are there and no others are known.
bool EdgeRoots::is_the_total(const Branches& branches, const Vec2& q) {
  for (const Branch& b : branches) {
    const double slack = kOffBoundary * carrier_.field(b.field).map.rounding(b.at.x);
    if (carrier_.field(b.field).domain.worst(b.at).value > slack || carrier_.hidden(b.field, b.at))
      return false;
  }
  return carrier_.find(q).size() <= branches.size();
}

bool EdgeRoots::find(const Vec2& from, const Vec2& to, RectangleTotals& over,
                     const PossibleTotal& sum, int level, std::vector<TotalSeed>& seeds) {
  for (std::size_t k = 0; k < over.near.size(); ++k) {
    if ((sum.near >> k & 1u) && !(over.near[k].over.inside && over.near[k].over.clear))
      return false;
  }
  const End a = end_at(from, over, sum), b = end_at(to, over, sum);
  if (!a.known || !b.known) return false;
  if (a.near != b.near && over.near.size() > 1) return false;
  if (a.near != sum.near && b.near != sum.near) return true;
  const double L = levels_[level];
  // Between the bright end and a caustic the total takes all that exceeds the end's.
  if (a.near != b.near && (a.near ? a : b).E > L) return true;
  if (a.near == b.near && (a.E - L) * (b.E - L) > 0.0) return true;
  return a.near == sum.near ? add_root(a, from, b, to, level, seeds)
                            : add_root(b, to, a, from, level, seeds);
}

// From the end a, up to b or to the caustic in between; false if it is not there.
bool EdgeRoots::add_root(const End& a, const Vec2& from, const End& b, const Vec2& to, int level,
                         std::vector<TotalSeed>& seeds) {
  const double L = levels_[level];
  const bool rises = a.near != b.near || a.E < b.E;
  Branches at = a.branches;
  double low = 0.0, high = 1.0, E = a.E;
  Vec2 q = from;
  while (high - low > kShortestBracket && std::abs(E - L) > kArcRoot * L) {
    const double w = 0.5 * (low + high);
    Branches next = at;
    q = from + w * (to - from);
    if (!carrier_.carry(next, q)) {
      high = w;
      continue;
    }
    E = total_of(next).E;
    ((E < L) == rises ? low : high) = w;
    at = std::move(next);
  }
  if (!carrier_.carry(at, q) || std::abs(total_of(at).E - L) > kOnLevel * L) return false;
  if (is_the_total(at, q)) seeds.push_back({level, q, std::move(at)});
  return true;
}

}  // namespace caustic::solver
