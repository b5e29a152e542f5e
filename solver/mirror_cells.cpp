#include "solver/mirror_cells.h"

#include <algorithm>

namespace caustic::solver {

namespace {

// Points so many roundings outside of a box are in it.
constexpr double kOnBox = 1e3;
// What is not enclosed is divided to this share of the scene, whatever it is asked for: it could
// reach all of the receiver.
constexpr double kLeastIrregular = 1e-3;
// A cell may be too large to show what becomes of its light, but its parts not.
constexpr int kPassageHalvings = 4;

}  // namespace

MirrorCells::MirrorCells(const ForwardMap& map, bool may_be_hidden, Budget& budget)
    : map_(map),
      way_(map),
      may_be_hidden_(may_be_hidden),
      least_(kLeastIrregular * map.system().diameter()) {
  const auto& mirror = map.mirror();
  auto cover = geometry::cover_by_graphs(*mirror.shape, mirror.bounds, mirror.region,
                                         [&] { return budget.exhausted(); });
  charts_ = std::move(cover.charts);
  for (int i = 0; i < static_cast<int>(charts_.size()) && !budget.exhausted(); ++i) {
    const auto& chart = charts_[i];
    add(i, {chart.own[chart.first()], chart.own[chart.second()], chart.reach, false}, roots_);
  }
}

geometry::IntervalVec3 MirrorCells::box(int i) const {
  const auto& chart = chart_of(cells_[i]);
  geometry::IntervalVec3 box;
  box[chart.first()] = cells_[i].cell.s;
  box[chart.second()] = cells_[i].cell.t;
  box[chart.along()] = cells_[i].cell.z;
  return box;
}

// (S78): |A|³ ∇E is smooth where A vanishes.
std::array<MirrorCell::Steep, 2> MirrorCells::steepness(int upward) const {
  const Slopes &A = field_.a, &flux = field_.flux;
  const auto& [q, r] = field_.q;
  const double turn = map_.map().side() * upward;
  const Interval E_s = flux.s * A.v - flux.v * A.s, E_t = flux.t * A.v - flux.v * A.t;
  const Interval G[2] = {turn * (E_s * r.t - E_t * r.s), turn * (E_t * q.s - E_s * q.t)};
  const Interval most(A.v.magnitude());
  std::array<MirrorCell::Steep, 2> out;
  for (std::size_t c = 0; c < 2; ++c) {
    const double least = (Interval(G[c].mignitude()) / (most * most * most)).lo;
    if (sign_of(G[c]) != 0 && least > 0.0) out[c] = {sign_of(G[c]), least};
  }
  return out;
}

bool MirrorCells::holds(const std::vector<int>& cells, const Point& x) const {
  const double slack = kOnBox * map_.map().rounding(x);
  return std::any_of(cells.begin(), cells.end(), [&](int i) {
    const geometry::IntervalVec3 at = box(i);
    for (int k = 0; k < 3; ++k) {
      const Interval& w = at[static_cast<std::size_t>(k)];
      if (x[k] < w.lo - slack || x[k] > w.hi + slack) return false;
    }
    return true;
  });
}

// Unless it is proven that nothing comes from there.
void MirrorCells::add(int chart, const GraphCell& cell, std::vector<int>& to) {
  MirrorCell next;
  next.chart = chart;
  next.cell = cell;
  if (!map_.narrow(charts_[chart], next.cell)) return;
  map_.enclose(charts_[chart], next.cell, field_);
  if (field_.dark) return;
  const auto& bounds = field_.bounds;
  if (std::any_of(bounds.begin(), bounds.end(), [](const Slopes& h) { return h.v.lo > 0.0; }))
    return;
  next.regular = field_.regular;
  next.along_s = cell.s.width() >= cell.t.width();
  if (field_.regular) {
    const auto& [q, r] = field_.q;
    next.image = {q.v, r.v};
    const auto& receiver = map_.map().receiver();
    for (int k = 0; k < 3; ++k) {
      next.leaving[static_cast<std::size_t>(k)] = receiver.u[k] * field_.leaving[0] +
                                                  receiver.v[k] * field_.leaving[1] +
                                                  receiver.m[k] * field_.leaving[2];
    }
    next.along_s = std::max(q.s.magnitude(), r.s.magnitude()) * cell.s.width() >=
                   std::max(q.t.magnitude(), r.t.magnitude()) * cell.t.width();
    next.inside = std::all_of(bounds.begin(), bounds.begin() + map_.domain_bounds(),
                              [](const Slopes& h) { return h.v.hi <= 0.0; });
    next.sign = sign_of(field_.a.v);
    if (field_.flux.v.lo > 0.0)
      next.least = (Interval(field_.flux.v.lo) / Interval(field_.a.v.magnitude())).lo;
    next.steep = steepness(field_.upward);
  }
  to.push_back(static_cast<int>(cells_.size()));
  cells_.push_back(std::move(next));
}

Passage MirrorCells::passage(const std::vector<int>& cells) {
  return may_be_hidden_ ? passage(cells, kPassageHalvings) : Passage::clear;
}

// The same of all, or unknown.
Passage MirrorCells::passage(const std::vector<int>& cells, int halvings) {
  std::optional<Passage> all;
  for (const int i : cells) {
    const Passage own = passage(i, halvings);
    if (own == Passage::unknown || own != all.value_or(own)) return Passage::unknown;
    all = own;
  }
  return all.value_or(Passage::hidden);
}

Passage MirrorCells::passage(int i, int halvings) {
  if (!cells_[i].passage) {
    const MirrorCell& cell = cells_[i];
    const auto& receiver = map_.map().receiver();
    geometry::IntervalVec3 image;
    for (int k = 0; k < 3; ++k) {
      image[static_cast<std::size_t>(k)] = Interval(receiver.origin[k]) +
                                           receiver.u[k] * cell.image.u +
                                           receiver.v[k] * cell.image.v;
    }
    cells_[i].passage = cell.regular ? way_.passage(box(i), image, cell.leaving) : Passage::unknown;
  }
  if (*cells_[i].passage != Passage::unknown || halvings == 0) return *cells_[i].passage;
  if (!cells_[i].divided) divide(i);
  const std::vector<int> parts = cells_[i].parts;
  const Passage all = passage(parts, halvings - 1);
  cells_[i].passage = all;
  return all;
}

void MirrorCells::divide(int i) {
  GraphCell low = cells_[i].cell, high = low;
  const int chart = cells_[i].chart;
  if (cells_[i].along_s) {
    low.s.hi = high.s.lo = low.s.middle();
  } else {
    low.t.hi = high.t.lo = low.t.middle();
  }
  std::vector<int> parts;
  add(chart, low, parts);
  add(chart, high, parts);
  if (cells_[i].passage.value_or(Passage::unknown) != Passage::unknown) {
    for (const int part : parts) cells_[part].passage = cells_[i].passage;
  }
  cells_[i].parts = std::move(parts);
  cells_[i].divided = true;
}

std::vector<int> MirrorCells::reaching(const ReceiverCell& part, const std::vector<int>& cells,
                                       double size, Budget& budget) {
  std::vector<int> out, left(cells.rbegin(), cells.rend());
  while (!left.empty()) {
    const int i = left.back();
    left.pop_back();
    const MirrorCell& cell = cells_[i];
    if (intersection(cell.image.u, part.u).empty() || intersection(cell.image.v, part.v).empty() ||
        cell.passage == Passage::hidden)
      continue;
    const bool small = cell.regular ? cell.image.size() <= size
                                    : std::max(cell.cell.s.width(), cell.cell.t.width()) <= least_;
    if (small || (!cell.divided && budget.exhausted())) {
      out.push_back(i);
      continue;
    }
    if (!cells_[i].divided) divide(i);
    left.insert(left.end(), cells_[i].parts.rbegin(), cells_[i].parts.rend());
  }
  return out;
}

}  // namespace caustic::solver
