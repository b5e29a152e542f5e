#include "solver/explore.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <memory_resource>
#include <optional>
#include <unordered_map>

#include "geometry/opening.h"
#include "solver/cell_clipper.h"
#include "solver/chart_place.h"
#include "solver/subdivision.h"

namespace caustic::solver {

namespace {

// Cells along a chart's side before any refinement: of the only chart, of one of few that count in
// parts of their squares, and of others.
constexpr int kBaseOfOne = 12;
constexpr int kBaseOfFew = 6;
constexpr std::size_t kFewCharts = 12;
constexpr int kBaseOfMany = 4;
// Finest levels, counted from the base, for each reason to refine.
constexpr int kBoundaryDepth = 2;  // the domain's boundary passes, or something hides a part
constexpr int kFieldDepth = 8;     // a, σ or q vary
constexpr int kPathEndDepth = 5;   // some paths end
constexpr int kPoleDepth = 8;      // some rays leave the receiver's plane
constexpr int kMissDepth = 2;      // no sample has a path; further if something small is sought
constexpr int kImageDepth = 24;    // the image is coarse against the window
constexpr int kSourceDepth = 40;   // the light is near
// The image of a cell inside the window: at most this share of the window's diagonal.
constexpr double kImageShare = 0.2;
// Largest difference between a corner and what gradients predict there, as a share of the largest.
constexpr double kFieldVariation = 0.2;
constexpr double kImageVariation = 0.1;
// How far beyond the samples of a cell its values may reach: a share of their spread, and how often
// the difference between the middle and the mean of the corners.
constexpr double kOvershoot = 0.1;
constexpr double kBulge = 2.0;
// Half the radius of a cell that the aperture cuts is at most the radius of what that leaves.
constexpr double kOpeningShare = 0.5;
// After so many cells nothing is refined further than this: a scene that needs more is degenerate.
constexpr std::size_t kDeepCells = 20000;
// Next to a light there are as many at every distance from it, which count by themselves.
constexpr std::size_t kDeepCellsNear = 60000;
constexpr int kLateDepth = 4;

constexpr std::int64_t kFinest = std::int64_t{1} << kChartDepth;

struct Span {
  double lo = geometry::kInfinity, hi = -geometry::kInfinity;
  void include(double v) {
    lo = std::min(lo, v);
    hi = std::max(hi, v);
  }
  double width() const { return hi - lo; }
};

// The values of a function at a cell's corners, then in its middle.
struct Values : Span {
  double corners = 0.0, middle = 0.0;
  void include(double v) {
    Span::include(v);
    corners += middle;
    middle = v;
  }
  /// How far the function may go beyond its samples: a quadratic one by what the middle differs
  /// from the corners' mean.
  double overshoot() const {
    return kOvershoot * width() + kBulge * std::abs(middle - 0.25 * corners);
  }
  /// No change of sign among the samples nor within the overshoot beyond them.
  bool positive() const { return lo - overshoot() > 0.0; }
  bool negative() const { return hi + overshoot() < 0.0; }
};

class Explorer {
 public:
  Explorer(Evaluator& evaluate, const Domain& domain, const OpticalSystem& system,
           const Hidden& hidden, bool unseen_too)
      : evaluate_(evaluate),
        domain_(domain),
        system_(system),
        map_(evaluate.map()),
        hidden_(hidden),
        unseen_too_(unseen_too),
        window_(system.receiver().half.norm() * 2.0) {
    const auto& mirror = map_.mirror();
    result_.charts = map_.shape().charts({mirror.region, system.center(), system.diameter()});
  }

  Exploration run();

 private:
  struct Square {
    int chart;
    std::int64_t i, j, size;  // corner and side in units of 1/(base · kFinest)
    int depth;
    int approached = 0;  // levels of the depth for which a light is near
  };
  // Cells that are divided to seek something small do not count as finer: that begins when it is
  // found. Those that are divided since a light is near do not either, for what varies, and for
  // where paths pass if none has been found to.
  enum class Verdict { discard, refine, approach, seek, keep };
  struct View {  // corners in order, then the middle
    std::array<int, 5> samples;
    double radius = 0.0;
    bool cut = false;
    const FieldPoint& operator()(const Exploration& e, int k) const {
      return e.samples[samples[k]];
    }
  };

  bool outside(int chart, const Point& middle, double radius) const;
  double find_opening() const;
  int sample(int chart, std::int64_t i, std::int64_t j);
  View look(const Square& c);
  Verdict judge(const Square& c, View& view);
  bool varies(const View& view) const;
  void keep(const Square& c, const View& view);
  Between between_rays(const View& view) const;
  Verdict judge_at_path_ends(View& view);
  bool wide_on_later(const View& view) const;
  bool hides(int sample);
  std::optional<double> hidden_share(const View& view);
  double hidden_share(int chart, const std::vector<Corner>& polygon);
  double coordinate(std::int64_t i) const {
    return static_cast<double>(i) / (base_ * double(kFinest));
  }

  bool late(const Square& c) const {
    return c.approached > 0 ? seen_near_ >= kDeepCellsNear : seen_ - seen_near_ >= kDeepCells;
  }

  Evaluator& evaluate_;
  const Domain& domain_;
  const OpticalSystem& system_;
  const ForwardMap& map_;
  const Hidden& hidden_;
  const bool unseen_too_;
  double window_;
  double opening_ = geometry::kInfinity;  // radius of what the aperture leaves, m
  int base_ = kBaseOfOne;
  std::size_t seen_ = 0, seen_near_ = 0;
  Exploration result_;
  std::pmr::monotonic_buffer_resource memory_;
  std::pmr::unordered_map<ChartPlace, int, ChartPlaceHash> known_{&memory_};
  std::pmr::unordered_map<int, bool> hidden_known_{&memory_};
  CellClipper clip_{result_, evaluate_, domain_};
};

// Outside the aperture or the chart's cell for sure?
bool Explorer::outside(int chart, const Point& middle, double radius) const {
  const auto excludes = [&](const auto& bound) {
    return bound.lower_bound_within(middle, radius) > 0.0;
  };
  const auto &bounds = map_.mirror().bounds, &cell = result_.charts[chart].cell;
  return std::any_of(bounds.begin(), bounds.end(), excludes) ||
         std::any_of(cell.begin(), cell.end(), excludes);
}

// Climbs from the middle of every cell of the base that the aperture may touch.
double Explorer::find_opening() const {
  const auto& bounds = map_.mirror().bounds;
  std::vector<Point> starts;
  double largest = 0.0;
  const double step = 1.0 / base_;
  for (std::size_t k = 0; k < result_.charts.size(); ++k) {
    const auto& chart = result_.charts[k];
    for (int i = 0; i < base_; ++i) {
      for (int j = 0; j < base_; ++j) {
        const Point middle = chart.point((i + 0.5) * step, (j + 0.5) * step);
        const double radius = (chart.point(i * step, j * step) - middle).norm();
        if (!std::isfinite(radius) || outside(static_cast<int>(k), middle, kRadiusFactor * radius))
          continue;
        starts.push_back(middle);
        largest = std::max(largest, radius);
      }
    }
  }
  return geometry::opening_radius(map_.shape(), bounds, starts, largest);
}

int Explorer::sample(int chart, std::int64_t i, std::int64_t j) {
  const auto [entry, fresh] = known_.try_emplace(ChartPlace{chart, i, j}, 0);
  if (fresh) entry->second = add_sample(result_, evaluate_, chart, coordinate(i), coordinate(j));
  return entry->second;
}

Explorer::View Explorer::look(const Square& c) {
  const std::int64_t half = c.size / 2;
  View view{{sample(c.chart, c.i, c.j), sample(c.chart, c.i + c.size, c.j),
             sample(c.chart, c.i + c.size, c.j + c.size), sample(c.chart, c.i, c.j + c.size),
             sample(c.chart, c.i + half, c.j + half)}};
  const Point& middle = view(result_, 4).x;
  for (int k = 0; k < 4; ++k) {
    view.radius = std::max(view.radius, kRadiusFactor * (view(result_, k).x - middle).norm());
  }
  return view;
}

bool Explorer::hides(int sample) {
  const auto [entry, fresh] = hidden_known_.try_emplace(sample, false);
  if (fresh) entry->second = hidden_(result_.samples[sample]);
  return entry->second;
}

// Of the samples inside the domain; none if there are none.
std::optional<double> Explorer::hidden_share(const View& view) {
  if (!hidden_) return 0.0;
  double hidden = 0.0, all = 0.0;
  for (int k = 0; k < 5; ++k) {
    if (!domain_.contains(view(result_, k))) continue;
    const double share = k < 4 ? 0.125 : 0.5;  // of the cell that is nearest to this sample
    all += share;
    hidden += hides(view.samples[k]) ? share : 0.0;
  }
  return all > 0.0 ? std::optional(hidden / all) : std::nullopt;
}

// Of a part between samples: what is in its middle.
double Explorer::hidden_share(int chart, const std::vector<Corner>& polygon) {
  if (!hidden_) return 0.0;
  Vec2 middle = Vec2::Zero();
  for (const Corner& corner : polygon) middle += Vec2(corner.s, corner.t);
  middle /= static_cast<double>(polygon.size());
  const int k = add_sample(result_, evaluate_, chart, middle.x(), middle.y());
  return domain_.contains(result_.samples[k]) && hides(k) ? 1.0 : 0.0;
}

// a, σ and q at the corners against what the gradients there and in the middle predict, to third
// order. Linear and quadratic changes are seen by seeding as they are, whose tests use the same
// gradients; so a cell is only refined for more. Where a is all rounding there is nothing to
// resolve.
bool Explorer::varies(const View& view) const {
  int degenerate = 0;
  for (int k = 0; k < 5; ++k) degenerate += view(result_, k).looks_degenerate();
  if (degenerate >= 4) return false;
  const FieldPoint& m = view(result_, 4);
  double a_max = 0, flux_max = 0, a_off = 0, flux_off = 0, q_off = 0;
  Span u, v;
  for (int k = 0; k < 4; ++k) {
    const FieldPoint& f = view(result_, k);
    const Vec3 dx = f.x - m.x;
    a_off = std::max(a_off, std::abs(f.a - m.a - 0.5 * (f.grad_a + m.grad_a).dot(dx)));
    flux_off =
        std::max(flux_off, std::abs(f.flux - m.flux - 0.5 * (f.grad_flux + m.grad_flux).dot(dx)));
    q_off = std::max(q_off, (f.q - m.q - 0.5 * (f.push_forward(dx) + m.push_forward(dx))).norm());
    a_max = std::max(a_max, std::abs(f.a));
    flux_max = std::max(flux_max, std::abs(f.flux));
    u.include(f.q.x());
    v.include(f.q.y());
  }
  return a_off > kFieldVariation * a_max || flux_off > kFieldVariation * flux_max ||
         q_off > kImageVariation * std::hypot(u.width(), v.width());
}

Explorer::Verdict Explorer::judge(const Square& c, View& view) {
  const int deepest = late(c) ? kLateDepth : kImageDepth;
  const Point& middle = view(result_, 4).x;
  if (outside(c.chart, middle, view.radius)) return Verdict::discard;
  for (const auto& bound : map_.mirror().bounds) view.cut |= bound.value(middle) > -view.radius;
  if (view.cut && view.radius * kOpeningShare > opening_ && c.depth < deepest) {
    return Verdict::refine;
  }
  if (near_light(system_.light(), middle, view.radius)) {
    if (c.depth < (late(c) ? kLateDepth : kSourceDepth)) return Verdict::approach;
    ++result_.unresolved;
    return Verdict::discard;
  }

  const int depth = c.depth - c.approached;
  int finite = 0;
  for (int k = 0; k < 5; ++k) finite += view(result_, k).finite;
  if (finite < 5) {
    if (depth < kMissDepth) return Verdict::refine;
    const Between rays = late(c) ? Between::dense : between_rays(view);
    if (rays == Between::perhaps) return Verdict::seek;
    if (finite == 0 && rays != Between::mixed) return Verdict::discard;
    if (c.depth < kPathEndDepth) return Verdict::refine;
    if (finite == 0) return Verdict::discard;
    if (map_.paths_may_end()) return judge_at_path_ends(view);
    ++result_.unresolved;
    return Verdict::discard;
  }

  // Light arrives in the window where |P| <= half·|m·D| with P = q (m·D), which is smooth also
  // where rays become parallel to the receiver and q has a pole.
  const Vec2& half = map_.receiver().half;
  Span facing, u, v;  // u and v of the image inside the window
  Values cosine, beyond[4];
  double behind = geometry::kInfinity;
  const int plane = domain_.silhouette() + 1;
  for (int k = 0; k < 5; ++k) {
    const FieldPoint& f = view(result_, k);
    cosine.include(f.cos_alpha);
    facing.include(f.facing);
    u.include(std::clamp(f.q.x(), -half.x(), half.x()));
    v.include(std::clamp(f.q.y(), -half.y(), half.y()));
    for (int i = 0; i < 2; ++i) {
      beyond[2 * i].include((f.q[i] - half[i]) * f.facing);
      beyond[2 * i + 1].include((f.q[i] + half[i]) * f.facing);
    }
    behind = std::min(behind, domain_.value(plane, f));
  }
  bool unseen = cosine.negative();
  for (int i = 0; i < 4; i += 2) {
    const Values &a = beyond[i], &b = beyond[i + 1];
    unseen |= (a.positive() && b.positive()) || (a.negative() && b.negative());
    view.cut |= !(a.positive() && b.negative()) && !(a.negative() && b.positive());
  }
  if (unseen && !unseen_too_) return Verdict::discard;
  if (facing.lo < 0.0 && facing.hi > 0.0) {
    if (c.depth < kPoleDepth) return Verdict::refine;
    result_.unresolved += !unseen;
    return Verdict::discard;
  }
  unseen |= behind > view.radius;
  view.cut |= !cosine.positive() || behind > -view.radius;

  for (int i = domain_.first_later(); i < domain_.size() && (!unseen || unseen_too_); ++i) {
    Values h;
    for (int k = 0; k < 5; ++k) h.include(domain_.value(i, view(result_, k)));
    unseen |= h.positive();
    view.cut |= !h.negative();
  }
  if (unseen && !unseen_too_) return Verdict::discard;
  if (view.cut && c.depth < deepest && wide_on_later(view)) return Verdict::refine;
  if (depth < deepest && std::hypot(u.width(), v.width()) > kImageShare * window_) {
    return Verdict::refine;
  }
  if (depth < std::min(kFieldDepth, deepest) && varies(view)) return Verdict::refine;
  if (depth < kBoundaryDepth && view.cut) return Verdict::refine;
  if (depth < kBoundaryDepth) {
    const double hidden = hidden_share(view).value_or(0.0);
    if (hidden > 0.0 && hidden < 1.0) return Verdict::refine;
  }
  return unseen ? Verdict::discard : Verdict::keep;
}

// Some samples have no path, or none has: how those pass that get nearest to what the others miss.
Between Explorer::between_rays(const View& view) const {
  std::array<NearMiss, 5> rays;
  int missed = -1;
  for (int k = 0; k < 5; ++k) {
    if (view(result_, k).finite) continue;
    rays[k] = map_.near_miss(view(result_, k).x);
    missed = std::max(missed, rays[k].hop);
  }
  if (missed < 0) return Between::dense;
  for (int k = 0; k < 5; ++k) {
    const FieldPoint& f = view(result_, k);
    if (!f.finite) continue;
    const Point& o = f.hits[missed - 1].y;
    rays[k] = {missed, o, f.hits[missed].y - o};
  }
  return between(rays, rays[4], map_.surface(missed).region);
}

// A cell in which paths begin to miss a surface, or to be reflected where they should pass: E → 0
// there, so it is clipped and counts unless its image is elsewhere.
Explorer::Verdict Explorer::judge_at_path_ends(View& view) {
  const Vec2& half = map_.receiver().half;
  Span cosine, q[2];
  for (int k = 0; k < 5; ++k) {
    const FieldPoint& f = view(result_, k);
    if (!f.finite) continue;
    cosine.include(f.cos_alpha);
    for (int i = 0; i < 2; ++i) q[i].include(f.q[i]);
  }
  view.cut = true;
  if (cosine.hi <= 0.0) return Verdict::discard;
  for (int i = 0; i < 2; ++i) {
    const double slack = std::max(q[i].width(), kImageShare * window_);
    if (q[i].lo - slack > half[i] || q[i].hi + slack < -half[i]) return Verdict::discard;
  }
  return Verdict::keep;
}

// Does the cell cover more of a later surface than what exists of that?
bool Explorer::wide_on_later(const View& view) const {
  for (int hop = 1; hop < map_.hop_count(); ++hop) {
    const Point& middle = view(result_, 4).hits[hop].y;
    double radius = 0.0;
    for (int k = 0; k < 4; ++k) {
      radius = std::max(radius, (view(result_, k).hits[hop].y - middle).norm());
    }
    if (radius * kOpeningShare > 0.5 * map_.surface(hop).region.diagonal()) return true;
  }
  return false;
}

void Explorer::keep(const Square& c, const View& view) {
  std::vector<Corner> polygon;
  const int di[4] = {0, 1, 1, 0}, dj[4] = {0, 0, 1, 1};
  for (int k = 0; k < 4; ++k) {
    polygon.push_back(
        {coordinate(c.i + di[k] * c.size), coordinate(c.j + dj[k] * c.size), view.samples[k]});
  }
  const auto& cell = result_.charts[c.chart].cell;
  const bool whole = std::all_of(polygon.begin(), polygon.end(), [&](const Corner& corner) {
    const FieldPoint& f = result_.samples[corner.sample];
    return domain_.contains(f) && geometry::exists_at(cell, f.x);
  });
  if (!whole) polygon = clip_(c.chart, std::move(polygon));
  if (polygon.empty()) return;
  const auto share = hidden_share(view);
  const double hidden = share ? *share : hidden_share(c.chart, polygon);
  result_.cells.push_back(
      {c.chart, std::move(polygon), whole, view.samples[4], view.radius, hidden});
}

int base_for(const std::vector<geometry::Chart>& charts) {
  if (charts.size() == 1) return kBaseOfOne;
  const bool few = charts.size() <= kFewCharts && !charts.empty() && !charts[0].cell.empty();
  return few ? kBaseOfFew : kBaseOfMany;
}

Exploration Explorer::run() {
  base_ = base_for(result_.charts);
  opening_ = find_opening();
  known_.reserve(4096);
  result_.samples.reserve(4096);
  // Coarse cells first: if the finest ones are too many (kDeepCells), they are so far away, and
  // what is near has been resolved before.
  std::deque<Square> queue;
  for (int chart = 0; chart < static_cast<int>(result_.charts.size()); ++chart) {
    for (int i = 0; i < base_; ++i) {
      for (int j = 0; j < base_; ++j) {
        queue.push_back({chart, i * kFinest, j * kFinest, kFinest, 0});
      }
    }
  }
  while (!queue.empty()) {
    if (seen_ % kBetweenChecks == 0 && evaluate_.budget().exhausted()) return std::move(result_);
    const Square c = queue.front();
    queue.pop_front();
    ++seen_;
    seen_near_ += c.approached > 0;
    View view = look(c);
    const Verdict verdict = judge(c, view);
    const std::int64_t half = c.size / 2;
    if (verdict == Verdict::discard) {
      ++result_.discarded;
    } else if (verdict == Verdict::keep) {
      keep(c, view);
    } else if (half < 2) {
      ++result_.unresolved;  // a coordinate of the middle would be no integer
    } else {
      const int depth = c.depth + (verdict != Verdict::seek);
      const int approached = c.approached + (verdict == Verdict::approach);
      for (const std::int64_t i : {std::int64_t{0}, half}) {
        for (const std::int64_t j : {std::int64_t{0}, half}) {
          queue.push_back({c.chart, c.i + i, c.j + j, half, depth, approached});
        }
      }
    }
  }
  result_.dark = std::none_of(result_.samples.begin(), result_.samples.end(),
                              [](const FieldPoint& f) { return f.finite && f.flux > 0.0; });
  return std::move(result_);
}

}  // namespace

int add_sample(Exploration& e, Evaluator& evaluate, int chart, double s, double t) {
  e.samples.push_back(evaluate(e.charts[chart].point(s, t)));
  return static_cast<int>(e.samples.size()) - 1;
}

Exploration explore(Evaluator& evaluate, const Domain& domain, const OpticalSystem& system,
                    const Hidden& hidden, bool unseen_too) {
  return Explorer(evaluate, domain, system, hidden, unseen_too).run();
}

double image_area(const Exploration& e, const Cell& cell) {
  double twice = 0.0;
  for (std::size_t k = 0; k < cell.polygon.size(); ++k) {
    const Vec2& a = e.samples[cell.polygon[k].sample].q;
    const Vec2& b = e.samples[cell.polygon[(k + 1) % cell.polygon.size()].sample].q;
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * std::abs(twice);
}

}  // namespace caustic::solver
