#include "solver/certify_total.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <numeric>
#include <set>

#include "solver/axis_turns.h"
#include "solver/edge_roots.h"
#include "solver/rectangle_totals.h"

namespace caustic::solver {

namespace {

// Cells whose images have at most this share of a rectangle are kept for its parts.
constexpr double kKeptShare = 4.0;
// Larger rectangles, in widths of the receiver, are divided if it is not shown that nothing hides
// their light: smaller ones may show it. What these do not show is undecided.
constexpr double kUnclearShare = 1.0 / 64.0;
// More sheets that are in a part of a rectangle only, and it is divided.
constexpr std::size_t kMostPartial = 4;

// Enclosures that say nothing contain everything.
bool may_be(const Interval& E, double level) { return !(level < E.lo) && !(level > E.hi); }

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
        carrier_(system, fields, budget),
        roots_(carrier_, mirrors_, levels) {
    for (const FamilyField* field : fields)
      mirrors_.emplace_back(field->map, field->visibility.has_value(), budget);
  }

  TotalCertificate run();

 private:
  struct Rectangle {
    ReceiverCell part;
    std::vector<std::vector<int>> cells;  // of each mirror
    std::vector<int> open;                // levels not settled there
  };
  // A rectangle in which every total that may have the level is monotone along an axis.
  struct Settled {
    Rectangle rectangle;
    std::vector<Axes> axes;  // by level; none: it is not there
  };

  void prove_boundaries();
  bool treat_all();
  void treat(Rectangle rectangle);
  void divide(const Rectangle& rectangle);
  bool sheets_of(Rectangle& rectangle, RectangleTotals& over);
  using Turns = std::map<int, std::vector<AxisTurn>>;
  Turns unsearched() const;
  void search_turns();
  bool search(Rectangle& rectangle, const std::vector<AxisTurn>& turns);

  const OpticalSystem& system_;
  const std::vector<const FamilyField*>& fields_;
  const std::vector<double>& levels_;
  Budget& budget_;
  const ContourCertificateOptions& options_;
  SheetCarrier carrier_;
  std::vector<MirrorCells> mirrors_;
  EdgeRoots roots_;
  std::deque<Rectangle> queue_;
  std::vector<Settled> settled_;
  std::set<AxisTurn::Key> searched_;
  std::size_t rectangles_ = 0;
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

// All that may reach the rectangle, but what next to a caustic exceeds the highest level in
// question; false if it cannot be told.
bool TotalCertifier::sheets_of(Rectangle& rectangle, RectangleTotals& over) {
  const double size = kKeptShare * rectangle.part.size(), highest = levels_[rectangle.open.back()];
  for (int i = 0; i < static_cast<int>(mirrors_.size()); ++i) {
    rectangle.cells[i] = mirrors_[i].reaching(rectangle.part, rectangle.cells[i], size, budget_);
    auto found = sheets_over(rectangle.part, mirrors_[i], rectangle.cells[i], rectangle.part.size(),
                             carrier_.evaluator(i));
    if (!found) return false;
    for (EnclosedSheet& sheet : found->sheets) {
      over.clear &= sheet.clear;
      (sheet.certain && sheet.clear ? over.certain : over.partial).push_back({i, std::move(sheet)});
    }
    for (NearCaustic& near : found->near) {
      if (near.least > highest) continue;
      over.clear &= near.clear;
      over.near.push_back({i, std::move(near), {}});
    }
  }
  return over.optional() <= kMostPartial;
}

// (S79): which levels are there, and along which axes all totals that may have them are monotone.
void TotalCertifier::treat(Rectangle rectangle) {
  RectangleTotals over;
  if (!sheets_of(rectangle, over)) return divide(rectangle);
  if (!over.clear && rectangle.part.size() > kUnclearShare * system_.receiver().width())
    return divide(rectangle);
  std::vector<Axes> axes(levels_.size(), kNoAxis);
  std::vector<bool> met(levels_.size(), false);
  Interval all = Interval::empty_set();
  over.each([&](const PossibleTotal& sum) {
    all = hull(all, sum.E);
    for (const int level : rectangle.open) {
      if (!may_be(sum.E, levels_[level])) continue;
      axes[level] = static_cast<Axes>((met[level] ? axes[level] : kBothAxes) & sum.monotone());
      met[level] = true;
    }
  });
  Rectangle left = rectangle;
  std::erase_if(left.open, [&](int level) { return !met[level] || axes[level] != kNoAxis; });
  std::erase_if(rectangle.open, [&](int level) { return met[level] && axes[level] == kNoAxis; });
  if (!left.open.empty()) divide(left);
  std::vector<int> unclear = over.clear ? std::vector<int>{} : rectangle.open;
  std::erase_if(unclear, [&](int level) { return !may_be(all, levels_[level]); });
  if (!unclear.empty()) result_.undecided.push_back({rectangle.part, std::move(unclear)});
  std::erase_if(rectangle.open, [&](int level) { return !met[level]; });
  if (!rectangle.open.empty()) settled_.push_back({std::move(rectangle), std::move(axes)});
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
  const auto side = [&](Rectangle& r) -> Interval& { return axis == 0 ? r.part.u : r.part.v; };
  side(low).hi = side(high).lo = side(low).middle();
  queue_.push_back(std::move(low));
  queue_.push_back(std::move(high));
}

// False if a limit of cells or time is met.
bool TotalCertifier::treat_all() {
  while (!queue_.empty()) {
    if (rectangles_ >= options_.max_cells || budget_.exhausted()) return false;
    Rectangle next = std::move(queue_.front());
    queue_.pop_front();
    ++rectangles_;
    treat(std::move(next));
  }
  return true;
}

// False if some of its turns cannot be told.
bool TotalCertifier::search(Rectangle& rectangle, const std::vector<AxisTurn>& turns) {
  RectangleTotals over;
  if (!sheets_of(rectangle, over)) return false;
  bool told = true;
  over.each([&](const PossibleTotal& sum) {
    for (const AxisTurn& turn : turns) {
      if (!may_be(sum.E, levels_[turn.level])) continue;
      told = told && roots_.find(turn.from, turn.to, over, sum, turn.level, result_.arcs);
    }
  });
  return told;
}

// By rectangle.
TotalCertifier::Turns TotalCertifier::unsearched() const {
  std::vector<MonotonePart> parts;
  for (const Settled& s : settled_) parts.push_back({s.rectangle.part, s.axes});
  Turns turns;
  for (const AxisTurn& turn : axis_turns(parts)) {
    if (!searched_.contains(turn.key())) turns[turn.rectangle].push_back(turn);
  }
  return turns;
}

// Rectangles with turns that cannot be told are divided.
void TotalCertifier::search_turns() {
  for (const auto& [i, turns] : unsearched()) {
    ++rectangles_;
    Rectangle& rectangle = settled_[i].rectangle;
    if (search(rectangle, turns)) {
      for (const AxisTurn& turn : turns) searched_.insert(turn.key());
    } else {
      divide(rectangle);
      rectangle.open.clear();
    }
  }
  std::erase_if(settled_, [](const Settled& s) { return s.rectangle.open.empty(); });
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
  while (!queue_.empty() && treat_all()) search_turns();
  if (!queue_.empty()) result_.exhausted = true;
  if (!queue_.empty() && !budget_.cancelled()) {
    for (const auto& [i, turns] : unsearched()) queue_.push_back(settled_[i].rectangle);
    for (const Rectangle& r : queue_) result_.undecided.push_back({r.part, r.open});
  }
  result_.cells += rectangles_;
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
