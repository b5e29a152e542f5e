#include "solver/path_search.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "solver/subdivision.h"

namespace caustic::solver {

namespace {

// Cells along a chart's side before any refinement, by the number of charts.
constexpr int kGridOfOne = 12;
constexpr int kGridOfMany = 4;
// Finest levels, counted from the base: of cells with a fold through p, of those in which rays
// break off or jump.
constexpr int kFoldDepth = 20;
constexpr int kBrokenDepth = 7;
// Cells none of whose nine places is lit are dark from here on.
constexpr int kDarkDepth = 1;
// Cells none of whose nine rays arrives, with nothing small between them, are taken for empty once
// they look this small from the light.
constexpr double kSeekShare = 0.05;
constexpr int kSeekDepth = 7;
// Second differences of rays above this share of the first ones, in cells this small: a jump, where
// rays pass a silhouette on their way.
constexpr double kJump = 0.5;
// What a cell's rays do between samples, from the derivatives of one of them.
constexpr double kSpreadFactor = 2.0;
// Rays that lean more than this (cosine) against the middle one say nothing linear.
constexpr double kLeastCosine = 0.3;
// The image of a cell reaches beyond its samples by at most this many second differences.
constexpr double kImageReach = 1.0;
// Newton from the cell's linear image converges to its only root where the least stretch exceeds
// the second differences so many times: Kantorovich's ½ needs 2√2.
constexpr double kInjective = 3.0;
// Each step takes a factor of the bending over the stretch off the error of the start.
constexpr int kPreimageSteps = 3;
// Questions are first expected within this share of the scene about each other.
constexpr double kFirstRegion = 0.02;
// Work for one point: a scene that needs more is a perfect focus.
constexpr std::size_t kMaxNewCells = 20000;
constexpr std::size_t kMaxPaths = 100;
// Newton's steps; one is the last if the next would be below this share of the scene.
constexpr int kMaxNewtonSteps = 24;
constexpr double kNextStep = 1e-15;
// Halving the way to a place from where no ray arrives ends at this share of the scene.
constexpr double kLastStep = 1e-9;
// Roots nearer than this share of the scene are one.
constexpr double kSameSolution = 1e-8;

// Of the nine rays of a cell, s fastest.
constexpr std::array<int, 4> kCorners{0, 2, 6, 8};

double max3(double a, double b, double c) { return std::max(a, std::max(b, c)); }

}  // namespace

// Second differences of a 3 × 3 grid of vectors, s fastest: the largest ones.
struct PathSearch::Bending {
  double ss, tt, st;
  explicit Bending(const std::array<Vec2, 9>& y) {
    const auto bend = [&](int a, int b, int c) { return (y[a] - 2.0 * y[b] + y[c]).squaredNorm(); };
    ss = std::sqrt(max3(bend(0, 1, 2), bend(3, 4, 5), bend(6, 7, 8)));
    tt = std::sqrt(max3(bend(0, 3, 6), bend(1, 4, 7), bend(2, 5, 8)));
    st = 0.25 * (y[0] - y[2] - y[6] + y[8]).norm();
  }
};

// The nine rays of a cell where they meet the plane through p across the middle one.
struct PathSearch::Locus {
  std::array<Vec2, 9> y;
  Vec2 target;
  Vec2 b_s, b_t;  // half differences through the middle
  double bending;
  double det() const { return b_s.x() * b_t.y() - b_s.y() * b_t.x(); }
  // The square of the smaller singular value of [b_s b_t] is the smaller root of
  // λ² − sum λ + det² = 0.
  bool injective() const {
    const double sum = b_s.squaredNorm() + b_t.squaredNorm();
    const double least = kInjective * bending, q = least * least;
    return 2.0 * q < sum && q * (q - sum) + det() * det() > 0.0;
  }
  Vec2 linear_preimage(const Vec2& at) const {
    const Vec2 m = at - y[4];
    return Vec2(m.x() * b_t.y() - m.y() * b_t.x(), b_s.x() * m.y() - b_s.y() * m.x()) / det();
  }
  // Of the target, to second order: the linear one of the target less what bends.
  Vec2 preimage(Vec2 st) const {
    const Vec2 ss = 0.5 * (y[3] - 2.0 * y[4] + y[5]), tt = 0.5 * (y[1] - 2.0 * y[4] + y[7]);
    const Vec2 cross = 0.25 * (y[0] - y[2] - y[6] + y[8]);
    for (int k = 0; k < kPreimageSteps; ++k) {
      const double s = st.x(), t = st.y();
      st = linear_preimage(target - s * s * ss - s * t * cross - t * t * tt);
    }
    return st;
  }
};

PathSearch::PathSearch(PencilTracer tracer, const geometry::Extent& extent, int lit_side)
    : tracer_(std::move(tracer)),
      charts_(tracer_.first().shape->charts(extent)),
      scale_(extent.scale),
      base_(charts_.size() == 1 ? kGridOfOne : kGridOfMany),
      lit_side_(lit_side),
      places_({}, 1.0) {
  const std::int64_t size = std::int64_t{1} << kChartDepth;
  for (int chart = 0; chart < static_cast<int>(charts_.size()); ++chart) {
    for (int i = 0; i < base_; ++i) {
      for (int j = 0; j < base_; ++j) {
        Cell cell;
        cell.chart = chart;
        cell.i = i * size;
        cell.j = j * size;
        cell.depth = 0;
        make(cell);
        cells_.push_back(cell);
      }
    }
  }
  std::vector<int> roots(cells_.size());
  std::iota(roots.begin(), roots.end(), 0);
  places_ = LocationTree(std::move(roots), kFirstRegion * extent.scale);
}

int PathSearch::sample(int chart, std::int64_t i, std::int64_t j) {
  const auto [entry, fresh] =
      known_.try_emplace(ChartPlace{chart, i, j}, static_cast<int>(samples_.size()));
  if (fresh) {
    const double unit = grid_unit();
    Sample s;
    s.x = charts_[chart].point(static_cast<double>(i) * unit, static_cast<double>(j) * unit);
    s.lit = lit_side_ == 0 || lit_from(s.x) == lit_side_;
    s.valid = s.x.allFinite() && tracer_.trace_ray(s.x, s.ray);
    samples_.push_back(s);
  }
  return entry->second;
}

Point PathSearch::place(const Cell& cell, double s, double t) const {
  const double unit = grid_unit();
  const auto half = static_cast<double>(half_side(cell));
  const auto i = static_cast<double>(cell.i), j = static_cast<double>(cell.j);
  return charts_[cell.chart].point(std::clamp((i + half * (1.0 + s)) * unit, 0.0, 1.0),
                                   std::clamp((j + half * (1.0 + t)) * unit, 0.0, 1.0));
}

// What of nine places becomes of a cell: what kind it is, and if rays of it arrive, how they
// spread.
void PathSearch::make(Cell& cell) {
  const std::int64_t half = half_side(cell);
  Nine index;
  int valid = 0, lit = 0;
  double radius = 0.0;
  for (int k = 0; k < 9; ++k) {
    index[k] = sample(cell.chart, cell.i + (k % 3) * half, cell.j + (k / 3) * half);
    valid += samples_[index[k]].valid;
    lit += samples_[index[k]].lit;
  }
  const Point& middle = samples_[index[4]].x;
  for (const int k : index) radius = std::max(radius, (samples_[k].x - middle).norm());
  const bool near = near_light(tracer_.light(), middle, radius);
  if (lit == 0 && cell.depth >= kDarkDepth && !near) return;
  const auto outside = [&](const std::vector<geometry::Bound>& bounds) {
    return std::any_of(bounds.begin(), bounds.end(), [&](const auto& bound) {
      return bound.lower_bound_within(middle, kRadiusFactor * radius) > 0.0;
    });
  };
  if (outside(*tracer_.first().bounds) || outside(charts_[cell.chart].cell)) return;
  if (near) {
    cell.seeks = true;
    cell.kind = Kind::wide;
    return;
  }
  const Between missed = valid < 9 ? between_rays(index) : Between::dense;
  if (valid == 0 && missed != Between::perhaps) {
    const bool large = cell.level() < kSeekDepth && apparent_size(middle, radius) >= kSeekShare;
    if (missed == Between::nothing || !large) return;
  }
  cell.seeks = missed == Between::perhaps;
  const bool wide = valid == 0 || cell.seeks;
  cell.kind = valid == 9 ? Kind::smooth : wide ? Kind::wide : Kind::broken;
  if (valid == 0) return;
  set_rays(cell, index);
  // Beside the light directions vary as much, but there it is the cell that is too large.
  if (valid == 9 && cell.level() >= kBrokenDepth && tracer_.hops() > 1 &&
      apparent_size(middle, radius) < kSeekShare && jumps(index)) {
    cell.kind = Kind::broken;
  }
  if (cell.kind == Kind::broken) spread_by_derivatives(cell, index, radius);
  cell.reach_o *= kSpreadFactor;
  cell.reach_w *= kSpreadFactor;
  cell.behind *= kSpreadFactor;
}

// The rays that arrive in the frame of the middle one, or of any that there is; the cell is wide if
// some lean against it.
void PathSearch::set_rays(Cell& cell, const Nine& samples) const {
  const Sample* frame = &samples_[samples[4]];
  for (int k = 0; !frame->valid && k < 9; ++k) frame = &samples_[samples[k]];
  cell.w = frame->ray.w.normalized();
  cell.o = frame->ray.o;
  const geometry::Frame across(cell.w);
  cell.u = across.e1;
  cell.v = across.e2;
  Mat3 to_frame;
  to_frame << cell.u.transpose(), cell.v.transpose(), cell.w.transpose();
  std::array<Vec2, 9> at, slopes;
  for (int k = 0; k < 9; ++k) {
    const Sample& s = samples_[samples[k]];
    if (s.valid) {
      const Vec3 o = to_frame * (s.ray.o - cell.o), w = to_frame * s.ray.w;
      if (w.z() < kLeastCosine) cell.kind = Kind::wide;
      const Vec2 slope = w.head<2>() / w.z();
      cell.rays[k] = {o.head<2>() - o.z() * slope, slope};
      cell.reach_w = std::max(cell.reach_w, slope.norm());
      cell.reach_o = std::max(cell.reach_o, cell.rays[k].at.norm());
      cell.behind = std::max(cell.behind, o.norm());
    }
    at[k] = cell.rays[k].at;
    slopes[k] = cell.rays[k].slope;
  }
  const Bending o(at), w(slopes);
  cell.bending_o = o.ss + o.tt;
  cell.bending_w = w.ss + w.tt;
}

// A single sample has no spread: derivatives say what the rays between do.
void PathSearch::spread_by_derivatives(Cell& cell, const Nine& samples, double radius) const {
  for (int k = 0; k < 9; ++k) {
    Pencil pencil;
    const Point& x = samples_[samples[k]].x;
    if (!samples_[samples[k]].valid || !tracer_.trace(x, pencil)) continue;
    // Along the surface: off it they have no bound where light leaves grazing as it came.
    Vec3 N;
    tracer_.first().shape->value_gradient(x, N);
    const Mat3 along = Mat3::Identity() - N * N.transpose() / N.squaredNorm();
    pencil.dx *= along;
    pencil.dw *= along;
    cell.reach_o = std::max(cell.reach_o, radius * pencil.dx.norm());
    // Angles add up; from a right one on the plane across the middle ray is not met.
    const double angle =
        std::atan(cell.rays[k].slope.norm()) + kSpreadFactor * radius * pencil.dw.norm();
    cell.reach_w =
        std::max(cell.reach_w, angle < 0.5 * geometry::kPi ? std::tan(angle) : geometry::kInfinity);
    cell.behind = std::max(cell.behind, radius * pencil.dx.norm());
  }
}

int PathSearch::lit_from(const Point& x) const {
  Vec3 N;
  tracer_.first().shape->value_gradient(x, N);
  return N.dot(tracer_.incident(x)) < 0.0 ? 1 : -1;
}

// Square root of a cell's solid angle from the light.
double PathSearch::apparent_size(const Point& middle, double radius) const {
  const Vec3 in = tracer_.incident(middle);
  Vec3 N;
  tracer_.first().shape->value_gradient(middle, N);
  const double cosine = std::abs(N.dot(in)) / (N.norm() * in.norm());
  const double away = tracer_.light().index() == 0 ? in.norm() : scale_;
  return radius * std::sqrt(cosine) / away;
}

// Some of the nine rays do not arrive: how those pass that get nearest to what the others miss.
Between PathSearch::between_rays(const Nine& samples) const {
  std::array<NearMiss, 9> rays;
  int missed = -1;
  for (int k = 0; k < 9; ++k) {
    const Sample& s = samples_[samples[k]];
    if (s.valid) continue;
    rays[k] = {s.ray.missed, s.ray.o, s.ray.w};
    missed = std::max(missed, s.ray.missed);
  }
  if (missed < 0) return Between::mixed;
  for (int k = 0; k < 9; ++k) {
    const Sample& s = samples_[samples[k]];
    if (!s.valid) continue;
    const Point& o = s.ray.hits[missed - 1];
    rays[k] = {missed, o, s.ray.hits[missed] - o};
  }
  return between(rays, rays[4], tracer_.surfaces()[missed].region);
}

bool PathSearch::jumps(const Nine& samples) const {
  const auto ray = [&](int k) -> const Pencil& { return samples_[samples[k]].ray; };
  const auto size = [&](int a, int b) {
    return (ray(a).o - ray(b).o).norm() / scale_ + (ray(a).w - ray(b).w).norm();
  };
  const auto bend = [&](int a, int b, int c) {
    const Pencil &x = ray(a), &y = ray(b), &z = ray(c);
    return (x.o - 2.0 * y.o + z.o).norm() / scale_ + (x.w - 2.0 * y.w + z.w).norm();
  };
  double first = 0.0, second = 0.0;
  for (int k = 0; k < 3; ++k) {
    first = max3(first, size(3 * k, 3 * k + 2), size(k, k + 6));
    second = max3(second, bend(3 * k, 3 * k + 1, 3 * k + 2), bend(k, k + 3, k + 6));
  }
  return second > kJump * first;
}

int PathSearch::split(int index) {
  const int first = static_cast<int>(cells_.size());
  const std::int64_t half = half_side(cells_[index]);
  for (int k = 0; k < 4; ++k) {
    Cell child;
    child.chart = cells_[index].chart;
    child.i = cells_[index].i + (k % 2) * half;
    child.j = cells_[index].j + (k / 2) * half;
    child.depth = cells_[index].depth + 1;
    child.sought = cells_[index].sought + cells_[index].seeks;
    make(child);
    cells_.push_back(child);
  }
  cells_[index].children = first;
  return first;
}

// True unless no ray of the cell comes within `radius` of p. The locus is that of p.
bool PathSearch::may_pass(const Cell& cell, const Point& p, double radius, Locus& locus) const {
  const Vec3 d = p - cell.o;
  const double tau = cell.w.dot(d);
  if (tau < -cell.behind - radius) return false;
  locus.target = {cell.u.dot(d), cell.v.dot(d)};
  const double reach = cell.reach_o + (std::abs(tau) + radius) * cell.reach_w + radius;
  if (locus.target.squaredNorm() > reach * reach) return false;
  if (cell.kind == Kind::broken) return true;

  auto& y = locus.y;
  const auto meet = [&](int k) { y[k] = cell.rays[k].at + tau * cell.rays[k].slope; };
  for (const int k : kCorners) meet(k);
  // A first look at the box about the corners and all that second differences could be.
  const double far = std::abs(tau) + radius;
  const double around = kImageReach * (cell.bending_o + far * cell.bending_w) + radius +
                        radius / kSpreadFactor * cell.reach_w;
  const Vec2 lo = y[0].cwiseMin(y[2]).cwiseMin(y[6].cwiseMin(y[8])) - locus.target;
  const Vec2 hi = y[0].cwiseMax(y[2]).cwiseMax(y[6].cwiseMax(y[8])) - locus.target;
  if (lo.maxCoeff() > around || hi.minCoeff() < -around) return false;
  for (const int k : {1, 3, 4, 5, 7}) meet(k);
  const Bending bending(y);
  locus.bending = bending.ss + 2.0 * bending.st + bending.tt;
  locus.b_s = 0.5 * (y[5] - y[3]);
  locus.b_t = 0.5 * (y[7] - y[1]);
  // Within the ball the target moves by the radius, each ray by its slope and second differences by
  // those of the slopes times as much.
  const double beyond = kImageReach * (bending.ss + bending.tt + radius * cell.bending_w) + radius;
  // The image lies between its corners, along any direction, but for what it bends beyond.
  const auto apart = [&](const Vec2& axis) {
    const double at = axis.dot(locus.target), size = beyond * axis.norm();
    bool below = true, above = true;
    for (const int k : kCorners) {
      const double value = axis.dot(y[k]) - at;
      const double moves =
          radius > 0.0 ? size + radius * std::abs(axis.dot(cell.rays[k].slope)) : size;
      below &= value < -moves;
      above &= value > moves;
    }
    return below || above;
  };
  return !apart({-locus.b_s.y(), locus.b_s.x()}) && !apart({-locus.b_t.y(), locus.b_t.x()});
}

// Newton on the miss of p across the ray, along the first surface.
void PathSearch::refine(const Point& start, const Point& p, Answer& answer) const {
  const auto& shape = *tracer_.first().shape;
  const auto project = [&](Point x) {
    Vec3 N;
    for (int k = 0; k < 4; ++k) {
      const double g = shape.value_gradient(x, N);
      const Vec3 step = N * (g / N.squaredNorm());
      x -= step;
      if (!(step.squaredNorm() > 1e-26 * scale_ * scale_)) break;
    }
    return x;
  };
  Pencil pencil;
  Point x = start, before = start;
  double last = 0.0;
  for (int k = 0; k < kMaxNewtonSteps; ++k) {
    if (!x.allFinite()) return;
    if (!tracer_.trace(x, pencil)) {
      // Beyond where the ray still meets every surface: half the way.
      if ((x - before).squaredNorm() <= kLastStep * kLastStep * scale_ * scale_) return;
      x = project(0.5 * (x + before));
      continue;
    }
    before = x;
    Vec3 N;
    shape.value_gradient(x, N);
    const geometry::Frame along(N.normalized()), across(pencil.w);
    const Vec3 d = p - pencil.o;
    const double tau = pencil.w.dot(d);
    const Mat3 motion = pencil.dx + tau * pencil.dw;
    const Vec3 m1 = motion * along.e1, m2 = motion * along.e2;
    const double a = across.e1.dot(m1), b = across.e1.dot(m2), c = across.e2.dot(m1),
                 e = across.e2.dot(m2);
    const double r1 = across.e1.dot(d), r2 = across.e2.dot(d), det = a * e - b * c;
    Vec3 step = ((e * r1 - b * r2) / det) * along.e1 + ((a * r2 - c * r1) / det) * along.e2;
    double size = step.norm();
    if (!std::isfinite(size)) return;
    const double room = 0.3 * scale_;
    if (size > room) {
      step *= room / size;
      size = room;
    }
    x = project(x + step);
    // Quadratic convergence: C δ² after δ.
    const double next = k > 0 ? size * (size / last) * (size / last) : size;
    // Or rounding is the limit; steps may be as small before, on something small.
    const bool stuck = k > 0 && size <= 1e-6 * scale_ && size > 0.5 * last &&
                       std::hypot(r1, r2) <= kSameSolution * scale_;
    if (next <= kNextStep * scale_ || stuck) {
      if (!tracer_.trace_ray(x, pencil) || !(pencil.w.dot(p - pencil.o) > 0.0)) return;
      for (const Pencil& other : answer.pencils) {
        if ((other.hits[0] - x).norm() <= kSameSolution * scale_) return;
      }
      answer.pencils.push_back(pencil);
      return;
    }
    last = size;
  }
}

void PathSearch::refine_from_samples(const Cell& cell, const Point& p, Answer& answer) {
  const std::int64_t half = half_side(cell);
  for (int k = 0; k < 9; ++k) {
    const int index = sample(cell.chart, cell.i + (k % 3) * half, cell.j + (k / 3) * half);
    if (samples_[index].valid) refine(samples_[index].x, p, answer);
  }
}

// Of these cells and what they have been divided into, those that may send light into a ball.
std::vector<int> PathSearch::narrowed(const std::vector<int>& cells, const Point& p,
                                      double radius) const {
  std::vector<int> left, stack = cells;
  while (!stack.empty()) {
    const int index = stack.back();
    const Cell& cell = cells_[index];
    stack.pop_back();
    if (cell.kind == Kind::dead) continue;
    Locus locus;
    if (cell.kind != Kind::wide && !may_pass(cell, p, radius, locus)) continue;
    if (cell.children >= 0 && !(cell.kind == Kind::smooth && locus.injective())) {
      for (int k = 0; k < 4; ++k) stack.push_back(cell.children + k);
    } else {
      left.push_back(index);
    }
  }
  return left;
}

PathSearch::Answer PathSearch::through(const Point& p) {
  Answer answer;
  const std::size_t limit = cells_.size() + kMaxNewCells;
  stack_ = places_.at(p, [&](const auto& cells, const Point& centre, double radius) {
    return narrowed(cells, centre, radius);
  });
  while (!stack_.empty()) {
    const int index = stack_.back();
    stack_.pop_back();
    if (cells_[index].kind == Kind::dead) continue;
    if (answer.pencils.size() > kMaxPaths) {
      // A whole line or surface of paths.
      answer.undecided.push_back(answer.pencils.front().hits[0]);
      answer.pencils.clear();
      break;
    }
    const Kind kind = cells_[index].kind;
    bool split_further = kind == Kind::wide;
    Locus locus;
    if (kind != Kind::wide) {
      const Cell& cell = cells_[index];
      if (!may_pass(cell, p, 0.0, locus)) continue;
      if (kind == Kind::smooth && locus.injective()) {
        // The linear image misses by at most half a bending over the least stretch.
        const double slack = 1.0 + 1.0 / kInjective;
        const Vec2 st = locus.linear_preimage(locus.target);
        if (st.cwiseAbs().maxCoeff() <= slack) {
          const Vec2 better = locus.preimage(st);
          refine(place(cell, better.x(), better.y()), p, answer);
        }
        continue;
      }
      split_further = true;
    }
    const Cell& cell = cells_[index];
    const int deepest = kind == Kind::broken ? kBrokenDepth : kFoldDepth;
    const bool divisible = cell.level() < deepest && cell.depth + 2 < kChartDepth;
    if (split_further && divisible && (cell.children >= 0 || cells_.size() < limit)) {
      const int first = cell.children >= 0 ? cell.children : split(index);
      for (int k = 0; k < 4; ++k) stack_.push_back(first + k);
      continue;
    }
    if (kind == Kind::smooth || cells_.size() >= limit) {
      answer.undecided.push_back(place(cell, 0.0, 0.0));
    }
    refine_from_samples(cells_[index], p, answer);
  }
  return answer;
}

}  // namespace caustic::solver
