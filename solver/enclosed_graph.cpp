#include "solver/enclosed_graph.h"

#include "geometry/narrowed.h"

namespace caustic::solver {

using geometry::GraphChart;
using geometry::IntervalJet;
using geometry::IntervalVec3;

namespace {

// Rounds of interval Newton on the heights of a cell, and the share that is worth another.
constexpr int kHeightRounds = 6;
constexpr double kHeightShare = 0.7;

}  // namespace

void MeanValues::begin_middle() {
  middle_.clear();
  recording_ = true;
}

void MeanValues::begin_cell(const Interval& ds, const Interval& dt) {
  next_ = 0;
  recording_ = false;
  ds_ = ds;
  dt_ = dt;
}

void MeanValues::begin_alone() {
  middle_.clear();
  next_ = 0;
  recording_ = false;
}

IntervalJet MeanValues::operator()(const IntervalJet& a) {
  if (recording_) middle_.push_back(a);
  if (recording_ || next_ == middle_.size()) return a;
  const IntervalJet& m = middle_[next_++];
  const Interval s = meet(a.s, m.s + a.ss * ds_ + a.st * dt_);
  const Interval t = meet(a.t, m.t + a.st * ds_ + a.tt * dt_);
  return {meet(a.v, m.v + s * ds_ + t * dt_), s, t, a.ss, a.st, a.tt};
}

bool narrow(const geometry::Surface& shape, const GraphChart& chart, GraphCell& cell) {
  const std::size_t i = chart.first(), j = chart.second(), k = chart.along();
  IntervalVec3 box, middle;
  box[i] = cell.s;
  box[j] = cell.t;
  middle[i] = cell.s.middle();
  middle[j] = cell.t.middle();
  for (int round = 0; round < kHeightRounds; ++round) {
    box[k] = cell.z;
    middle[k] = cell.z.middle();
    const auto over = shape.enclose(box);
    if (!over.g.contains_zero()) return false;
    IntervalVec3 N = over.gradient;
    if (N[k].contains_zero()) N = geometry::narrowed(shape, box).gradient;
    if (N[k].contains_zero()) break;
    const Interval g =
        shape.enclose(middle).g + N[i] * (cell.s - middle[i]) + N[j] * (cell.t - middle[j]);
    const Interval next = middle[k] - g / N[k];
    cell.whole |= next.lo > cell.z.lo && next.hi < cell.z.hi;
    const Interval cut = intersection(cell.z, next);
    if (cut.empty()) return false;
    const bool worthwhile = cut.width() < kHeightShare * cell.z.width();
    cell.z = cut;
    if (!worthwhile) break;
  }
  return !intersection(cell.z, chart.own[k]).empty();
}

GraphJets graph_jets(const geometry::Surface& shape, const GraphChart& chart, const GraphCell& cell,
                     MeanValues& mean) {
  const std::size_t i = chart.first(), j = chart.second(), k = chart.along();
  IntervalVec3 box;
  box[i] = cell.s;
  box[j] = cell.t;
  box[k] = cell.z;
  auto g = shape.enclose(box);
  const auto third = shape.enclose_third(box);
  const auto H = [&](std::size_t a, std::size_t b) -> const Interval& {
    constexpr std::size_t kPacked[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    return g.hessian[kPacked[a][b]];
  };
  const auto T = [&](std::size_t a, std::size_t b, std::size_t c) -> const Interval& {
    return third[geometry::packed_index(static_cast<int>(a), static_cast<int>(b),
                                        static_cast<int>(c))];
  };

  // (S71): the graph and ∇g along it, first as the box has it, then narrowed by its slopes.
  Interval z_s, z_t;
  IntervalVec3 H_s, H_t;  // Hessian times x_s, x_t
  const auto find_slopes = [&] {
    z_s = -(g.gradient[i] / g.gradient[k]);
    z_t = -(g.gradient[j] / g.gradient[k]);
    for (std::size_t a = 0; a < 3; ++a) {
      H_s[a] = H(a, i) + H(a, k) * z_s;
      H_t[a] = H(a, j) + H(a, k) * z_t;
    }
  };
  find_slopes();
  for (std::size_t a = 0; a < 3; ++a) {
    const Interval unknown = Interval::whole();
    g.gradient[a] = mean({g.gradient[a], H_s[a], H_t[a], unknown, unknown, unknown}).v;
  }
  find_slopes();
  const Interval z_ss = -((H_s[i] + z_s * H_s[k]) / g.gradient[k]);
  const Interval z_st = -((H_t[i] + z_s * H_t[k]) / g.gradient[k]);
  const Interval z_tt = -((H_t[j] + z_t * H_t[k]) / g.gradient[k]);
  GraphJets out;
  geometry::IntervalVecJet &x = out.x, &N = out.N;
  x[i] = {cell.s, 1.0, 0.0, 0.0, 0.0, 0.0};
  x[j] = {cell.t, 0.0, 1.0, 0.0, 0.0, 0.0};
  x[k] = {cell.z, z_s, z_t, z_ss, z_st, z_tt};
  for (std::size_t a = 0; a < 3; ++a) {
    const Interval T_ss = T(a, i, i) + 2.0 * z_s * T(a, i, k) + sqr(z_s) * T(a, k, k);
    const Interval T_st = T(a, i, j) + z_t * T(a, i, k) + z_s * T(a, j, k) + z_s * z_t * T(a, k, k);
    const Interval T_tt = T(a, j, j) + 2.0 * z_t * T(a, j, k) + sqr(z_t) * T(a, k, k);
    N[a] = {g.gradient[a],        H_s[a], H_t[a], T_ss + H(a, k) * z_ss, T_st + H(a, k) * z_st,
            T_tt + H(a, k) * z_tt};
  }
  out.upward = sign_of(g.gradient[k]);
  return out;
}

}  // namespace caustic::solver
