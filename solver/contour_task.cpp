#include "solver/contour_task.h"

#include <algorithm>
#include <optional>

#include "solver/corrector.h"
#include "solver/visible_pieces.h"

namespace caustic::solver {

namespace {

// Open curves shorter than this share of the chord tolerance are left out.
constexpr double kSpeckShare = 1e-2;
// Shares of the seed's cell: first step, and how near to the curve the corrector brings the seed.
constexpr double kFirstStepShare = 0.25;
constexpr double kSeedPosition = 1e-9;
// Vertices of a track may be this share of a cell off their curve, where E hardly varies. Another
// curve of the level that runs the same way is not so near: one that runs back lies between.
constexpr double kTrackPosition = 1e-6;
// A seed this near to its curve by Newton's step, as a share of its cell, is off by this share of
// the step at most; and this is the least cosine between tangents of one curve there.
constexpr double kNewtonShare = 0.2;
constexpr double kNewtonError = 0.2;
constexpr double kAlong = 0.9;

// What is kept of a traced curve to tell seeds that lie on it: places and unit tangents, close in
// memory, before visibility cuts it.
struct Track {
  std::vector<Point> x;
  std::vector<Vec3> t;
  bool closed;

  explicit Track(const Trace& trace) : t(trace.tangents), closed(trace.closed) {
    x.reserve(trace.vertices.size());
    for (const CurveVertex& v : trace.vertices) x.push_back(v.x);
    for (std::size_t begin = 0; begin < x.size(); begin += kBall) {
      Ball ball{x[std::min(begin + kBall / 2, x.size() - 1)], 0.0, begin,
                std::min(begin + kBall, x.size())};
      for (std::size_t i = begin; i < ball.end; ++i) {
        ball.radius = std::max(ball.radius, (x[i] - ball.center).norm());
      }
      balls.push_back(ball);
    }
  }
  // Of the vertices where the track runs as `way` does, the one nearest to y; size() if there is
  // none. A track next to it that turns back is another part of the curve, however near it is.
  std::size_t nearest(const Point& y, const Vec3& way) const {
    std::size_t best = x.size();
    double least2 = geometry::kInfinity, least = geometry::kInfinity;
    for (const Ball& ball : balls) {
      const double reach = least + ball.radius;
      if ((ball.center - y).squaredNorm() > reach * reach) continue;
      for (std::size_t i = ball.begin; i < ball.end; ++i) {
        const double d2 = (x[i] - y).squaredNorm();
        if (d2 < least2 && t[i].dot(way) >= 0.0) {
          least2 = d2;
          best = i;
        }
      }
      least = std::sqrt(least2);
    }
    return best;
  }

 private:
  static constexpr std::size_t kBall = 16;
  struct Ball {  // about neighbours on the track
    Point center;
    double radius;
    std::size_t begin, end;
  };
  std::vector<Ball> balls;
};

// A point against the cubic through two vertices with their tangents.
struct Gap {
  Point foot;
  Vec3 t;  // about the tangent there
  double off, sagitta;
};
std::optional<Gap> gap_to_cubic(const Track& track, std::size_t i, std::size_t j, const Point& x) {
  const Point &a = track.x[i], &b = track.x[j];
  const Vec3 chord = b - a;
  const double length = chord.norm(), w = chord.dot(x - a) / (length * length), v = 1.0 - w;
  if (!(w >= -1e-3 && w <= 1.0 + 1e-3)) return std::nullopt;
  const Vec3 bulge = (length * w * v * v) * (track.t[i] - chord / length) -
                     (length * w * w * v) * (track.t[j] - chord / length);
  const Point foot = a + w * chord + bulge;
  return Gap{foot, v * track.t[i] + w * track.t[j], (x - foot).norm(),
             bulge.norm() + 1e-3 * length * w * v};
}

// Is `same` true of x and a track next to it that runs as `way` does: of the nearest vertex, or one
// of the cubics that end there?
template <class Same>
bool on_a_track(const std::vector<Track>& tracks, const Point& x, const Vec3& way,
                const Same& same) {
  for (const Track& track : tracks) {
    const std::size_t n = track.x.size(), nearest = track.nearest(x, way);
    if (nearest == n) continue;
    const Point& vertex = track.x[nearest];
    if (same(Gap{vertex, track.t[nearest], (x - vertex).norm(), 0.0})) return true;
    for (const std::size_t begin : {(nearest + n - 1) % n, nearest}) {
      if (!track.closed && begin == n - 1) continue;
      const auto gap = gap_to_cubic(track, begin, (begin + 1) % n, x);
      if (gap && same(*gap)) return true;
    }
  }
  return false;
}

// Is a seed on a curve that has been traced? Surely within a twentieth of the sagitta from the
// cubic, since that is off by a fourth order only, and a curve that passes nearer does so elsewhere
// too; up to some sagittas the corrector tells, from the cubic's point next to the seed.
bool visited(const std::vector<Track>& tracks, const FieldPoint& seed, double fuzz,
             Evaluator& evaluate, const LevelFunction& level) {
  const Vec3 t = level.tangent(seed);
  return on_a_track(tracks, seed.x, t, [&](const Gap& gap) {
    if (gap.off > 4.0 * gap.sagitta + fuzz) return false;
    if (gap.off <= 0.05 * gap.sagitta + fuzz) return true;
    const auto on_curve =
        correct(evaluate, level, gap.foot, {1e-12, geometry::kInfinity, 2.0 * gap.off},
                seed.hits.get());
    if (!on_curve) return false;
    const Vec3 apart = on_curve->x - seed.x;
    return (apart - t * t.dot(apart)).norm() <= 0.2 * gap.off + fuzz;
  });
}

// The same of a seed not yet settled: Newton's step from it leads to a track, which runs the way
// its own curve does. Another curve of the level just there would run the other way, since f
// changes its sign between neighbours.
bool leads_to_track(const std::vector<Track>& tracks, const Seed& seed,
                    const LevelFunction& level) {
  const Vec3 slope = level.gradient(seed.at), t = level.tangent(seed.at);
  const Vec3 step = -(level.value(seed.at) / slope.squaredNorm()) * slope;
  const double length = step.norm();
  if (!(length <= kNewtonShare * seed.reach)) return false;
  return on_a_track(tracks, seed.at.x, t, [&](const Gap& gap) {
    if (gap.sagitta == 0.0 || gap.t.dot(t) < kAlong) return false;
    const Vec3 apart = gap.foot - seed.at.x - step;
    return (apart - t * t.dot(apart)).norm() <= kNewtonError * length + 0.05 * gap.sagitta;
  });
}

// The seed on its curve and inside the domain or on its boundary.
std::optional<FieldPoint> settle(const Seed& seed, Evaluator& evaluate, const Domain& domain,
                                 const LevelFunction& level, double residual) {
  const CorrectorOptions options{residual, kSeedPosition * seed.reach, seed.reach};
  auto f = correct(evaluate, level, seed.at, options);
  if (!f) return std::nullopt;
  const auto worst = domain.worst(*f);
  const double slack = 100.0 * evaluate.map().rounding(f->x);
  if (worst.value <= slack) return f;
  // Found on the chord of a curved boundary: onto the boundary itself, which the curve crosses
  // within the slice that the chord cuts off.
  CorrectorOptions within_slice = options;
  within_slice.trust = 2.0 * seed.reach;
  f = correct_at_end(evaluate, level,
                     LevelFunction::boundary_of(domain, worst.boundary), f->x, within_slice, f->hits.get());
  const double steep = f ? domain.gradient(worst.boundary, *f).norm() : 0.0;
  if (!f || domain.worst(*f).value > slack * (1.0 + steep)) return std::nullopt;
  return f;
}

// Too short to be seen: what rounding leaves between two boundaries where all levels meet, or where
// visibility flickers along a silhouette.
bool speck(const Trace& trace, double chord) {
  double length = 0.0;
  for (std::size_t i = 1; i < trace.vertices.size(); ++i) {
    length += (trace.vertices[i].uv - trace.vertices[i - 1].uv).norm();
    if (length > kSpeckShare * chord) return false;
  }
  return !trace.closed;
}

}  // namespace

void run(ContourTask& task, Budget& budget, double chord, double residual) {
  Evaluator evaluate(task.field->map, budget);
  const Domain domain = task.field->domain.without(task.level.boundary);
  std::vector<Track> tracks;
  for (const Seed& seed : task.seeds) {
    // At a silhouette where a vanishes too all levels meet, and none can be followed.
    const bool on_silhouette = !seed.at.lit() && !task.level.is_boundary();
    if (on_silhouette || leads_to_track(tracks, seed, task.level)) continue;
    if (budget.exhausted()) break;
    const auto f = settle(seed, evaluate, domain, task.level, residual);
    if (!f) {
      ++task.lost_seeds;
      continue;
    }
    const double fuzz = kTrackPosition * seed.reach + 1e3 * evaluate.map().rounding(f->x);
    if (visited(tracks, *f, fuzz, evaluate, task.level)) continue;
    const TraceOptions options{chord, residual, kFirstStepShare * seed.reach};
    Trace trace = trace_contour(evaluate, domain, task.level, *f, options);
    if (trace.vertices.size() < 2) {
      task.lost_seeds += trace.stalled;
      continue;
    }
    tracks.emplace_back(trace);
    if (!task.field->visibility || !task.seen_only) {
      if (!speck(trace, chord)) task.traces.push_back(std::move(trace));
      continue;
    }
    for (Trace& piece : visible_pieces(std::move(trace), *task.field->visibility, evaluate,
                                       task.level, residual)) {
      if (!speck(piece, chord)) task.traces.push_back(std::move(piece));
    }
  }
}

}  // namespace caustic::solver
