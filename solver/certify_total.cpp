#include "solver/certify_total.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>

#include "solver/enclosed_sheets.h"

namespace caustic::solver {

namespace {

// Cells whose images have at most this share of a rectangle are kept for its parts.
constexpr double kKeptShare = 4.0;
// Larger rectangles, in widths of the receiver, are divided if it is not shown that nothing hides
// their light: smaller ones may show it. What these do not show is undecided.
constexpr double kUnclearShare = 1.0 / 64.0;
// More sheets that are in a part of a rectangle only, and it is divided.
constexpr std::size_t kMostPartial = 4;
// Around a corner cells are divided so often, each time to this share, to tell its sheets apart.
constexpr int kCornerRounds = 4;
constexpr double kCornerCells = 0.25;
// A root on an edge is located to this share of the level or of the edge.
constexpr double kArcRoot = 1e-10;
constexpr double kShortestBracket = 1e-12;
constexpr double kOnLevel = 1e-6;  // where rounding does not let it come nearer
// Seeds up to so many roundings outside the domain lie on its boundary.
constexpr double kOffBoundary = 1e3;
// First hits this near to each other, in diameters of the scene, are of one sheet.
constexpr double kSamePlace = 1e-8;
// Paths arrive within this, in widths of the receiver.
constexpr double kOnPlace = 1e-12;

// Enclosures that say nothing contain everything.
bool may_be(const Interval& E, double level) { return !(level < E.lo) && !(level > E.hi); }

Interval& along(ReceiverCell& part, int axis) { return axis == 0 ? part.u : part.v; }

// One sheet of a field, or what comes from the neighbourhood of a caustic.
struct Sheet {
  int field;
  EnclosedSheet over;
};
struct Near {
  int field;
  NearCaustic over;
  /// What comes from there to the rectangle's corners, once asked for.
  struct Corner {
    Vec2 q;
    std::optional<Branches> branches;
  };
  std::vector<Corner> corners;
};

// A total that a rectangle may have: that of some of its sheets, and of some neighbourhoods of
// caustics.
struct Sum {
  std::vector<const Sheet*> sheets;
  unsigned near = 0;  // bits
  Interval E{0.0}, slope[2]{0.0, 0.0};

  void add(const Sheet& sheet) {
    sheets.push_back(&sheet);
    E += sheet.over.E;
    slope[0] += sheet.over.E_u;
    slope[1] += sheet.over.E_v;
  }
  void add(const NearCaustic& next, unsigned bit) {
    near |= bit;
    E = {(E + next.least).lo, geometry::kInfinity};
    for (std::size_t c = 0; c < 2; ++c) {
      const Interval steep(next.steep[c].least, geometry::kInfinity);
      slope[c] += next.steep[c].sign > 0   ? steep
                  : next.steep[c].sign < 0 ? -steep
                                           : Interval::whole();
    }
  }
};

// What may reach a rectangle.
struct Over {
  std::vector<Sheet> certain, partial;
  std::vector<Near> near;
  bool clear = true;  // nothing hides any of it
};

class TotalCertifier {
 public:
  TotalCertifier(const OpticalSystem& system, const std::vector<const FamilyField*>& fields,
                 const std::vector<double>& levels, Budget& budget,
                 const ContourCertificateOptions& options)
      : system_(system),
        fields_(fields),
        levels_(levels),
        budget_(budget),
        options_(options),
        carrier_(system, fields, budget) {
    for (const FamilyField* field : fields)
      mirrors_.emplace_back(field->map, field->visibility.has_value());
  }

  TotalCertificate run();

 private:
  struct Rectangle {
    ReceiverCell part;
    std::vector<std::vector<int>> cells;  // of each mirror
    std::vector<int> open;                // levels not settled there
  };
  // The total at one end of an edge.
  struct End {
    bool known = false;
    unsigned near = 0;  // neighbourhoods of caustics that something of it comes from
    Branches branches;
    double E = 0.0;
  };

  void prove_boundaries();
  void treat(Rectangle rectangle);
  void divide(const Rectangle& rectangle);
  bool sheets_of(Rectangle& rectangle, Over& over);
  bool settled(const Rectangle& rectangle, Over& over, const Sum& sum,
               const std::vector<int>& levels);
  bool search(const Vec2& from, const Vec2& to, Over& over, const Sum& sum,
              const std::vector<int>& levels);
  bool add_root(const End& a, const Vec2& from, const End& b, const Vec2& to, int level);
  End end_at(const Vec2& q, Over& over, const Sum& sum);
  const std::optional<Branches>& near_at(const Vec2& q, Near& near);
  std::optional<Branches> find_near(const Vec2& q, const Near& near);
  std::optional<Branch> branch_of(int field, const EnclosedSheet& sheet, const Vec2& q);
  bool is_the_total(const Branches& branches, const Vec2& q);
  bool is_among(const Branches& branches, const Branch& b) const;

  const OpticalSystem& system_;
  const std::vector<const FamilyField*>& fields_;
  const std::vector<double>& levels_;
  Budget& budget_;
  const ContourCertificateOptions& options_;
  SheetCarrier carrier_;
  std::vector<MirrorCells> mirrors_;
  std::deque<Rectangle> queue_;
  TotalCertificate result_;
};

void TotalCertifier::prove_boundaries() {
  for (int i = 0; i < static_cast<int>(fields_.size()); ++i) {
    const Domain& domain = fields_[i]->domain;
    std::vector<LevelFunction> targets{LevelFunction::caustic()};
    for (int b = 0; b <= domain.silhouette() + 1; ++b) {
      if (domain.first_like(b) == b) targets.push_back(LevelFunction::boundary_of(domain, b));
    }
    auto found = certify_contours(carrier_.evaluator(i), domain, targets, options_);
    for (Seed& seed : found.seeds) seed.target = targets[seed.target].boundary;
    result_.boundaries.push_back(std::move(found.seeds));
    for (UndecidedCell& cell : found.undecided) {
      result_.undecided_boundaries.emplace_back(i, std::move(cell));
    }
    result_.cells += found.cells;
    result_.exhausted |= found.exhausted;
  }
}

// The sheet's path to q; nothing if it is not found in the box that holds it.
std::optional<Branch> TotalCertifier::branch_of(int field, const EnclosedSheet& sheet,
                                                const Vec2& q) {
  Evaluator& evaluate = carrier_.evaluator(field);
  Point x;
  x[sheet.chart.along()] = sheet.cell.z.middle();
  x[sheet.chart.first()] = sheet.cell.s.middle();
  x[sheet.chart.second()] = sheet.cell.t.middle();
  const FieldPoint middle = evaluate.on_surface(x);
  if (!middle.finite) return std::nullopt;
  const double rounding = evaluate.map().rounding(middle.x);
  auto at = preimage(evaluate, middle, q, kOnPlace * system_.receiver().width());
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
std::optional<Branches> TotalCertifier::find_near(const Vec2& q, const Near& near) {
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

const std::optional<Branches>& TotalCertifier::near_at(const Vec2& q, Near& near) {
  for (const Near::Corner& corner : near.corners) {
    if (corner.q == q) return corner.branches;
  }
  near.corners.push_back({q, find_near(q, near)});
  return near.corners.back().branches;
}

bool TotalCertifier::is_among(const Branches& branches, const Branch& b) const {
  const double slack = kSamePlace * system_.diameter();
  return std::any_of(branches.begin(), branches.end(), [&](const Branch& other) {
    return other.field == b.field && (other.at.x - b.at.x).norm() <= slack;
  });
}

TotalCertifier::End TotalCertifier::end_at(const Vec2& q, Over& over, const Sum& sum) {
  End end;
  for (const Sheet* sheet : sum.sheets) {
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
bool TotalCertifier::is_the_total(const Branches& branches, const Vec2& q) {
  for (const Branch& b : branches) {
    const double slack = kOffBoundary * fields_[b.field]->map.rounding(b.at.x);
    if (fields_[b.field]->domain.worst(b.at).value > slack || carrier_.hidden(b.field, b.at))
      return false;
  }
  return carrier_.find(q).size() <= branches.size();
}

// (S79): the one root there may be on an edge along which the total is monotone. False if it cannot
// be told, for there may be caustics on the edge.
bool TotalCertifier::search(const Vec2& from, const Vec2& to, Over& over, const Sum& sum,
                            const std::vector<int>& levels) {
  const End a = end_at(from, over, sum), b = end_at(to, over, sum);
  if (!a.known || !b.known) return false;
  if (a.near != b.near && over.near.size() > 1) return false;
  if (a.near != sum.near && b.near != sum.near) return true;
  for (const int level : levels) {
    // Between the bright end and a caustic the total takes all that exceeds the end's.
    if (a.near != b.near && (a.near ? a : b).E > levels_[level]) continue;
    if (a.near == b.near && (a.E - levels_[level]) * (b.E - levels_[level]) > 0.0) continue;
    const bool found =
        a.near == sum.near ? add_root(a, from, b, to, level) : add_root(b, to, a, from, level);
    if (!found) return false;
  }
  return true;
}

// From the end a, up to b or to the caustic in between; false if it is not there.
bool TotalCertifier::add_root(const End& a, const Vec2& from, const End& b, const Vec2& to,
                              int level) {
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
  if (is_the_total(at, q)) result_.arcs.push_back({level, q, std::move(at)});
  return true;
}

// (S79): along u or v this total has one sign of its slope, so no arc is closed within the
// rectangle; and the roots on its two edges in that direction are found.
bool TotalCertifier::settled(const Rectangle& rectangle, Over& over, const Sum& sum,
                             const std::vector<int>& levels) {
  for (int axis = 0; axis < 2; ++axis) {
    if (sum.slope[axis].contains_zero()) continue;
    const auto searched = [&](bool upper) {
      ReceiverCell edge = rectangle.part;
      Interval& across = along(edge, 1 - axis);
      across = upper ? across.hi : across.lo;
      return search({edge.u.lo, edge.v.lo}, {edge.u.hi, edge.v.hi}, over, sum, levels);
    };
    if (searched(false) && searched(true)) return true;
  }
  return false;
}

// All that may reach the rectangle, but what next to a caustic exceeds the highest level in
// question; false if it cannot be told.
bool TotalCertifier::sheets_of(Rectangle& rectangle, Over& over) {
  const double size = kKeptShare * rectangle.part.size(), highest = levels_[rectangle.open.back()];
  for (int i = 0; i < static_cast<int>(mirrors_.size()); ++i) {
    rectangle.cells[i] = mirrors_[i].reaching(rectangle.part, rectangle.cells[i], size);
    auto found = sheets_over(rectangle.part, mirrors_[i], rectangle.cells[i], rectangle.part.size(),
                             carrier_.evaluator(i));
    if (!found) return false;
    for (EnclosedSheet& sheet : found->sheets) {
      over.clear &= sheet.clear;
      (sheet.certain && sheet.clear ? over.certain : over.partial).push_back({i, std::move(sheet)});
    }
    for (NearCaustic& near : found->near) {
      if (near.least > highest) continue;
      if (!near.inside) return false;
      over.near.push_back({i, std::move(near), {}});
    }
  }
  return over.partial.size() + over.near.size() <= kMostPartial;
}

void TotalCertifier::treat(Rectangle rectangle) {
  Over over;
  if (!sheets_of(rectangle, over)) return divide(rectangle);
  if (!over.clear && rectangle.part.size() > kUnclearShare * system_.receiver().width())
    return divide(rectangle);
  std::vector<int> left, doubtful = rectangle.open;
  double least = geometry::kInfinity, most = 0.0;
  const std::size_t partial = over.partial.size(), optional = partial + over.near.size();
  for (unsigned chosen = 0; chosen < 1u << optional; ++chosen) {
    Sum sum;
    for (const Sheet& sheet : over.certain) sum.add(sheet);
    for (std::size_t k = 0; k < optional; ++k) {
      if (!(chosen >> k & 1u)) continue;
      k < partial ? sum.add(over.partial[k])
                  : sum.add(over.near[k - partial].over, 1u << (k - partial));
    }
    least = std::min(least, sum.E.lo);
    most = std::max(most, sum.E.hi);
    std::vector<int> met;
    for (const int level : rectangle.open) {
      if (may_be(sum.E, levels_[level])) met.push_back(level);
    }
    if (met.empty() || settled(rectangle, over, sum, met)) continue;
    left.insert(left.end(), met.begin(), met.end());
  }
  std::sort(left.begin(), left.end());
  left.erase(std::unique(left.begin(), left.end()), left.end());
  rectangle.open = std::move(left);
  if (!rectangle.open.empty()) return divide(rectangle);
  std::erase_if(doubtful, [&](int level) { return !may_be({least, most}, levels_[level]); });
  if (!over.clear && !doubtful.empty()) result_.undecided.push_back({rectangle.part, doubtful});
}

// Or gives it up.
void TotalCertifier::divide(const Rectangle& rectangle) {
  const ReceiverCell& part = rectangle.part;
  if (part.size() <= options_.smallest * system_.receiver().width()) {
    result_.undecided.push_back({part, rectangle.open});
    return;
  }
  const int axis = part.u.width() >= part.v.width() ? 0 : 1;
  Rectangle low = rectangle, high = rectangle;
  along(low.part, axis).hi = along(high.part, axis).lo = along(low.part, axis).middle();
  queue_.push_back(std::move(low));
  queue_.push_back(std::move(high));
}

TotalCertificate TotalCertifier::run() {
  prove_boundaries();
  Rectangle all;
  const Vec2 half = system_.receiver().half;
  all.part = {{-half.x(), half.x()}, {-half.y(), half.y()}};
  for (const MirrorCells& mirror : mirrors_) all.cells.push_back(mirror.all());
  all.open.resize(levels_.size());
  std::iota(all.open.begin(), all.open.end(), 0);
  if (!levels_.empty()) queue_.push_back(std::move(all));
  std::size_t cells = 0;
  while (!queue_.empty()) {
    if (cells >= options_.max_cells || (cells % kBetweenChecks == 0 && budget_.exhausted())) {
      result_.exhausted = true;
      for (const Rectangle& r : queue_) result_.undecided.push_back({r.part, r.open});
      break;
    }
    Rectangle next = std::move(queue_.front());
    queue_.pop_front();
    ++cells;
    treat(std::move(next));
  }
  result_.cells += cells;
  return std::move(result_);
}

}  // namespace

TotalCertificate certify_total(const OpticalSystem& system,
                               const std::vector<const FamilyField*>& fields,
                               const std::vector<double>& levels, Budget& budget,
                               const ContourCertificateOptions& options) {
  return TotalCertifier(system, fields, levels, budget, options).run();
}

}  // namespace caustic::solver
