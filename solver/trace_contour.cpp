#include "solver/trace_contour.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "geometry/root_finding.h"
#include "solver/chord.h"
#include "solver/corrector.h"
#include "solver/hermite_curve.h"
#include "solver/predictor.h"
#include "solver/step_length.h"

namespace caustic::solver {

namespace {

// Predictor's error per unit of arc. Newton squares it, so one correction reaches rounding.
constexpr double kPredictorError = 1e-5;
// Largest turn of the tangent in one step, so that no step can hide a loop, and its cosine.
constexpr double kMaxTurn = 0.5;
constexpr double kMinTurnCosine = 0.8775825618903728;
// The corrector may move a point by this share of the step; more means another branch.
constexpr double kTrustShare = 0.05;
// The corrector brings points to the curve within this share of the step; near a critical value of
// E a small residual alone would not.
constexpr double kPositionShare = 1e-7;
// Largest motion on the receiver in one step, in widths of it.
constexpr double kMaxReceiverStep = 0.5;
// Steps shorter than this many roundings of x are a stall.
constexpr double kMinStepRoundings = 1e3;
// The predictor's error is not asked to be below so many of them.
constexpr double kLeastErrorRoundings = 4.0;
// Share of the chord tolerance that is used, since the estimate is of third order only, and how
// much less of it by a piece that is a whole step.
constexpr double kChordShare = 0.8;
constexpr double kLongShare = 0.2;
// A curve that cannot be followed further ends on a boundary that is nearer than this share of the
// receiver's width.
constexpr double kMeetingShare = 1e-6;
// All levels meet on a silhouette only where a vanishes too: below this share of its scale.
constexpr double kMeetingA = 1e-3;
// A curve is closed when it comes back to its start within this share of the last piece: above the
// corrector's error, far below the distance of another branch that a step could confuse it with.
constexpr double kClosureShare = 1e-4;
constexpr int kMaxInserted = 64;  // vertices in one step
constexpr int kMaxPending = 24;   // of them not yet accepted

struct Node {
  FieldPoint f;
  Vec3 t = Vec3::Zero();   // unit tangent, the way we go
  Vec2 dq = Vec2::Zero();  // its image on the receiver
  double s = 0.0;          // arc since the beginning of the step
  bool cusp = false;
};

struct Stop {
  bool closed = false;
  Ending ending = Ending::limit;
  bool clipped = false;
  bool stalled = false;
};

class Tracer final : public DirectionField {
 public:
  Tracer(Evaluator& evaluate, const Domain& domain, const LevelFunction& level,
         const TraceOptions& options)
      : evaluate_(evaluate), domain_(domain), level_(level), options_(options), predictor_(*this) {}

  Stop follow(const FieldPoint& seed, double sign, Trace& out);

  bool direction(const Point& x, Vec3& t) override {
    const FieldPoint f = evaluate_(x, near_);
    if (!f.finite) return false;  // then there are no hits, of which a boundary's tangent may ask
    t = sign_ * level_.tangent(f);
    return t.squaredNorm() > 0.5;
  }
  // The corrector works where the predictor asks for its last stage, which costs no evaluation
  // then.
  bool direction_at_end(const Point& x, Vec3& t) override {
    arrived_ = correct(evaluate_, level_, x,
                       {options_.residual, kPositionShare * step_, kTrustShare * step_}, near_);
    if (arrived_) t = sign_ * level_.tangent(*arrived_);
    return arrived_.has_value();
  }

  // Tangents point the way of the positive direction, whichever way we go.
  void append(const FieldPoint& f, Trace& out) {
    const double rounding = evaluate_.map().rounding(f.x);
    out.conditioning = std::max(out.conditioning, level_.residual_of_rounding(f, rounding));
    out.vertices.push_back(make_vertex(evaluate_.map(), level_, f));
    out.tangents.push_back(level_.tangent(f));
    if (f.hits) out.hits.push_back(f.hits);
  }

 private:
  Node node(const FieldPoint& f, double s) const {
    const Vec3 t = sign_ * level_.tangent(f);
    return {f, t, f.push_forward(t), s, false};
  }
  std::optional<Node> advance(const Node& from);
  double allowance(const Node& from, const Node& to) const;
  std::optional<Node> between(const Node& a, const Node& b, double s);
  CurvePlace place(const Node& a) const;
  double split(const Node& a, const Node& b) const;
  std::optional<Node> cusp_between(const Node& a, const Node& b);
  std::optional<Stop> stop_at_start(const Node& start) const;
  std::optional<Stop> accept(const Node& a, const Node& b, Trace& out);
  Stop stop_at_stall(const Node& last) const;
  bool closes(const Node& a, const Node& b);
  struct Way {
    std::array<double, 2> moved, bulge;  // of the place, of its image
  };
  static Way way(const Node& a, const Node& b);
  bool in_reach(int boundary, const Node& a, const Node& b, const Way& way);
  std::optional<double> leaves(int boundary, const Node& a, const Node& b);
  FieldPoint end_between(int boundary, const Node& a, const Node& b);

  Evaluator& evaluate_;
  const Domain& domain_;
  const LevelFunction& level_;
  const TraceOptions& options_;
  Predictor predictor_;
  double sign_ = 1.0;
  const Hit* near_ = nullptr;          // hits where the step begins
  StepLength length_;                  // of the next step
  double step_ = 0.0;                  // length of the step that the predictor holds
  std::optional<FieldPoint> arrived_;  // the corrected end of that step
  std::array<double, 2> travelled_{};  // by the place and by its image, so far
  std::vector<double> safe_until_;     // no boundary is met before that much is travelled
  Node start_;
  std::size_t accepted_ = 0;
  PassedPlaces passed_;  // vertices before the last one
};

// How many times as long the step could have been for its turn and its motion on the receiver.
double Tracer::allowance(const Node& from, const Node& to) const {
  const double turn = std::acos(std::clamp(to.t.dot(from.t), -1.0, 1.0));
  const double motion = (to.f.q - from.f.q).norm() / evaluate_.map().receiver().width();
  return StepLength::room(turn, kMaxTurn, motion, kMaxReceiverStep);
}

// One corrected step from `from`, as long as error, turn and motion on the receiver allow.
std::optional<Node> Tracer::advance(const Node& from) {
  const double rounding = evaluate_.map().rounding(from.f.x);
  near_ = from.f.hits.get();
  while (length_.now() > kMinStepRoundings * rounding) {
    step_ = length_.now();
    const auto step = predictor_.attempt(from.f.x, from.t, step_);
    if (!step.usable || !(arrived_->facing * from.f.facing > 0.0)) {
      length_.failed();
      continue;
    }
    const double allowed = std::max(kPredictorError * step_, kLeastErrorRoundings * rounding);
    const Node to = node(*arrived_, step_);
    if (length_.judge(step.error, allowed, allowance(from, to))) return to;
  }
  return std::nullopt;
}

// Where Newton's next step leads from a place that is kept as it is, if rounding lets it say so.
CurvePlace Tracer::place(const Node& a) const {
  const Vec3 slope = level_.gradient(a.f);
  const Vec3 step = -(level_.value(a.f) / slope.squaredNorm()) * slope;
  return {step.norm() <= kPositionShare * step_ ? Point(a.f.x + step) : a.f.x, a.t};
}

// The curve's point at arc s of the current step, between two of its nodes.
std::optional<Node> Tracer::between(const Node& a, const Node& b, double s) {
  const auto f = correct(
      evaluate_, level_, passed_.predict(place(a), place(b), predictor_.at(s / step_), step_),
      {options_.residual, kPositionShare * step_, (b.f.x - a.f.x).norm()}, a.f.hits.get());
  if (!f) return std::nullopt;
  return node(*f, s);
}

// Where on (0, 1) the next vertex between a and b is wanted; 1 if none is.
double Tracer::split(const Node& a, const Node& b) const {
  const double part = (b.s - a.s) / step_, ds = b.s - a.s;
  const double error = chord_error(a.f.q, b.f.q, ds * a.dq, ds * b.dq) / options_.chord;
  int pieces = 1;
  if (error > kChordShare - kLongShare * part * part) {
    pieces = std::max(2, static_cast<int>(std::ceil(std::sqrt(error / kChordShare))));
  }
  const double na = a.dq.norm(), nb = b.dq.norm();
  const bool turns = !a.cusp && !b.cusp && a.dq.dot(b.dq) < kMinTurnCosine * na * nb;
  if (turns && (b.f.q - a.f.q).norm() > options_.chord) pieces = std::max(pieces, 2);
  return 1.0 / std::min(pieces, kMaxInserted);
}

// On the caustic: the point where the curve's image stops and turns back (S11).
std::optional<Node> Tracer::cusp_between(const Node& a, const Node& b) {
  if (!level_.is_caustic() || a.cusp || b.cusp || a.dq.dot(b.dq) >= 0.0) return std::nullopt;
  const Vec2 line = a.dq.normalized();
  std::optional<Node> at;
  const auto speed = [&](double s) {
    auto next = between(a, b, s);
    if (!next) return 0.0;
    at = std::move(next);
    return at->dq.dot(line);
  };
  const double fast = std::max(a.dq.norm(), b.dq.norm());
  geometry::illinois_root(
      speed, [&](double, double v) { return std::abs(v) <= 1e-12 * fast; }, a.s, b.s,
      a.dq.dot(line), b.dq.dot(line));
  if (at) at->cusp = at->dq.norm() <= 1e-6 * fast;
  return at && at->cusp ? at : std::nullopt;
}

// A start on the boundary with the inside behind us.
std::optional<Stop> Tracer::stop_at_start(const Node& start) const {
  const double slack = 1e3 * evaluate_.map().rounding(start.f.x);
  for (int i = 0; i < domain_.size(); ++i) {
    const Vec3 slope = domain_.gradient(i, start.f);
    if (domain_.value(i, start.f) < -slack * (1.0 + slope.norm())) continue;
    if (slope.dot(start.t) > 0.0) return Stop{false, domain_.ending(i), domain_.is_clip(i), false};
  }
  return std::nullopt;
}

// Where all levels meet (a and σ vanish together on a rim, or a ray runs within the receiver's
// plane) E is undetermined and the curve cannot be followed to the end itself. That lies on a
// boundary.
Stop Tracer::stop_at_stall(const Node& last) const {
  const double near = kMeetingShare * evaluate_.map().receiver().width();
  int nearest = -1;
  double least = near;
  const bool meet = !level_.is_isolux() || std::abs(last.f.a) <= kMeetingA * last.f.scale_of_a();
  for (int i = 0; i < domain_.size(); ++i) {
    // A low level runs along the silhouette without ending there.
    if (domain_.ending(i) == Ending::silhouette && !meet) continue;
    const double h = std::abs(domain_.value(i, last.f));
    if (h < least) {
      least = h;
      nearest = i;
    }
  }
  if (nearest < 0) return Stop{false, Ending::limit, false, true};
  return Stop{false, domain_.ending(nearest), domain_.is_clip(nearest), false};
}

bool Tracer::closes(const Node& a, const Node& b) {
  const Vec3& t0 = start_.t;
  const Point& x0 = start_.f.x;
  const double before = t0.dot(a.f.x - x0), after = t0.dot(b.f.x - x0);
  const double length = (b.f.x - a.f.x).norm();
  if (accepted_ < 4 || !(before < 0.0 && after >= 0.0)) return false;
  if ((a.f.x - x0).norm() > 2.0 * length || b.t.dot(t0) < 0.0) return false;
  std::optional<Node> at;
  const auto ahead = [&](double s) {
    auto next = between(a, b, s);
    if (!next) return 0.0;
    at = std::move(next);
    return t0.dot(at->f.x - x0);
  };
  const double rounding = evaluate_.map().rounding(x0);
  geometry::illinois_root(
      ahead, [&](double, double h) { return std::abs(h) <= 1e-9 * length; }, a.s, b.s, before,
      after);
  if (after == 0.0) at = b;
  // What is left is across the curve, where the corrector is exact.
  return at && (at->f.x - x0).norm() <= kClosureShare * length + 1e3 * rounding;
}

// How far the place and its image move from a to b at most, and how far the cubics through both
// ends leave them behind.
Tracer::Way Tracer::way(const Node& a, const Node& b) {
  const double ds = b.s - a.s, fastest = std::max(a.dq.squaredNorm(), b.dq.squaredNorm());
  const double bulge = 0.25 * ds * std::sqrt(fastest);
  return {{ds, (b.f.q - a.f.q).norm() + bulge}, {0.25 * ds, bulge}};
}

// May the curve meet boundary i between a and b, the next two vertices? Not while it has moved less
// than it was inside when last asked, where that bounds the change of h.
bool Tracer::in_reach(int i, const Node& a, const Node& b, const Way& way) {
  const auto slope = domain_.slope_bound(i);
  if (slope == Domain::Slope::unknown) return true;
  const int kind = slope == Domain::Slope::of_place ? 0 : 1;
  if (travelled_[kind] < safe_until_[i]) return false;
  const double inside = -domain_.value(i, b.f);
  safe_until_[i] = travelled_[kind] + inside;
  return std::max(domain_.value(i, a.f), -inside) + way.bulge[kind] >= 0.0;
}

// Arc at which the curve is certainly beyond boundary i, if it gets there between a and b. A rise
// and fall inside the step shows in the cubic through both ends.
std::optional<double> Tracer::leaves(int i, const Node& a, const Node& b) {
  const double ha = domain_.value(i, a.f), hb = domain_.value(i, b.f), ds = b.s - a.s;
  const double da = domain_.slope(i, a.f, a.t, a.dq) * ds,
               db = domain_.slope(i, b.f, b.t, b.dq) * ds;
  // Two boundaries may coincide; the one that was located first keeps the end.
  const double fuzz = 16.0 * evaluate_.map().rounding(b.f.x) * (1.0 + std::abs(db) / ds);
  if (hb > fuzz) return b.s;
  if (da <= 0.0 || db >= 0.0 || std::max(ha, hb) + 0.25 * std::max(da, -db) <= 0.0) {
    return std::nullopt;
  }
  // Steepest place of the cubic's top: the root of its slope, by the secant of the end slopes.
  const double w = da / (da - db), v = 1.0 - w;
  const double top =
      ha * v * v * (1.0 + 2.0 * w) + hb * w * w * (3.0 - 2.0 * w) + da * w * v * v - db * w * w * v;
  if (top <= -0.1 * std::max(da, -db)) return std::nullopt;
  const auto c = between(a, b, a.s + w * ds);
  if (c && domain_.value(i, c->f) > 0.0) return c->s;
  return std::nullopt;
}

FieldPoint Tracer::end_between(int i, const Node& a, const Node& b) {
  Node inside = a;
  const double ha = std::min(domain_.value(i, a.f), -1e-300);
  const auto h = [&](double s) {
    const auto next = between(a, b, s);
    // Where all levels meet there is nothing to correct to: stay on this side.
    if (!next) return domain_.value(i, b.f);
    const double value = domain_.value(i, next->f);
    if (value <= 0.0 && next->s > inside.s) inside = *next;
    return value;
  };
  // Near enough for Newton, which then finishes.
  const double length = (b.f.x - a.f.x).norm();
  const double near = 1e-6 * std::abs(domain_.value(i, b.f) - ha);
  const double s = geometry::illinois_root(
      h, [&](double, double value) { return std::abs(value) <= near; }, a.s, b.s, ha,
      domain_.value(i, b.f));
  const auto end = correct_at_end(
      evaluate_, level_, LevelFunction::boundary_of(domain_, i), predictor_.at(s / step_),
      {options_.residual, geometry::kInfinity, length}, inside.f.hits.get());
  if (end) return *end;
  // As near as the corrector gets to the place where all levels meet.
  double outside = b.s;
  for (int k = 0; k < 50 && outside - inside.s > 1e-9 * step_; ++k) {
    const double middle = 0.5 * (inside.s + outside), before = inside.s;
    h(middle);
    if (inside.s == before) outside = middle;
  }
  return inside.f;
}

// Takes the piece from a to b, unless the curve closes or ends on it.
std::optional<Stop> Tracer::accept(const Node& a, const Node& b, Trace& out) {
  if (closes(a, b)) return Stop{true, {}, false, false};
  int boundary = -1;
  Node cut;
  const Node* end = &b;
  const Way on = way(a, b);
  for (std::size_t k = 0; k < travelled_.size(); ++k) travelled_[k] += on.moved[k];
  for (int i = 0; i < domain_.size(); ++i) {
    if (!in_reach(i, a, b, on)) continue;
    const auto beyond = leaves(i, a, *end);
    if (!beyond) continue;
    std::optional<Node> outside;
    if (*beyond < end->s) outside = between(a, *end, *beyond);
    const FieldPoint f = end_between(i, a, outside ? *outside : *end);
    cut = node(f, std::clamp(a.s + a.t.dot(f.x - a.f.x), a.s, end->s));
    end = &cut;
    boundary = i;
  }
  const bool moved = (end->f.x - a.f.x).norm() > 16.0 * evaluate_.map().rounding(a.f.x);
  if (moved || boundary < 0) {
    append(end->f, out);
    ++accepted_;
    evaluate_.budget().spend_vertices(1);
  }
  if (boundary < 0) return std::nullopt;
  return Stop{false, domain_.ending(boundary), domain_.is_clip(boundary), false};
}

// Follows the curve from the seed, which `out` has already, in one direction.
Stop Tracer::follow(const FieldPoint& seed, double sign, Trace& out) {
  sign_ = sign;
  length_ = StepLength(options_.first_step);
  accepted_ = 0;
  passed_.clear();
  travelled_ = {};
  safe_until_.assign(static_cast<std::size_t>(domain_.size()), 0.0);
  start_ = node(seed, 0.0);
  if (const auto stop = stop_at_start(start_)) return *stop;

  Node a = start_;
  std::array<Node, kMaxPending> pending;
  while (!evaluate_.budget().exhausted()) {
    auto b = advance(a);
    if (!b) return stop_at_stall(a);
    a.s = 0.0;
    pending[0] = std::move(*b);
    for (int count = 1; count > 0;) {
      const Node& next = pending[count - 1];
      if (count < kMaxPending) {
        std::optional<Node> c = cusp_between(a, next);
        const double w = c ? 1.0 : split(a, next);
        if (w < 1.0) c = between(a, next, a.s + w * (next.s - a.s));
        if (c && c->s > a.s && c->s < next.s) {
          pending[count++] = std::move(*c);
          continue;
        }
      }
      if (const auto stop = accept(a, next, out)) return *stop;
      passed_.remember(place(a), next.f.x);
      a = std::move(pending[--count]);
    }
  }
  return Stop{};
}

}  // namespace

CurveVertex make_vertex(const ForwardMap& map, const LevelFunction& level, const FieldPoint& f) {
  CurveVertex v;
  v.uv = f.q;
  v.p = map.receiver().point(f.q);
  v.x = f.x;
  v.residual = level.residual(f);
  v.arc_length = 0.0;
  v.irradiance = -1.0;
  v.gradient = Vec3::Zero();
  if (level.is_isolux()) {
    const Vec2 gradient = f.irradiance_gradient();
    v.irradiance = f.irradiance();
    v.gradient = gradient.x() * map.receiver().u + gradient.y() * map.receiver().v;
  }
  return v;
}

Trace trace_contour(Evaluator& evaluate, const Domain& domain, const LevelFunction& level,
                    const FieldPoint& seed, const TraceOptions& options) {
  Trace trace;
  const auto turn_round = [&] {
    std::reverse(trace.vertices.begin(), trace.vertices.end());
    std::reverse(trace.tangents.begin(), trace.tangents.end());
    std::reverse(trace.hits.begin(), trace.hits.end());
  };
  Tracer tracer(evaluate, domain, level, options);
  tracer.append(seed, trace);
  const Stop front = tracer.follow(seed, 1.0, trace);
  trace.closed = front.closed;
  if (!front.closed) {
    turn_round();
    const Stop back = tracer.follow(seed, -1.0, trace);
    turn_round();
    trace.ends = {back.ending, front.ending};
    trace.clipped = back.clipped || front.clipped;
    trace.stalled = back.stalled || front.stalled;
  }
  return trace;
}

}  // namespace caustic::solver
