#include "solver/total_arcs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "geometry/root_finding.h"
#include "solver/chord.h"
#include "solver/hermite_curve.h"
#include "solver/predictor.h"
#include "solver/step_length.h"

namespace caustic::solver {

namespace {

// The limits of a step are those of a sheet's curve (trace_contour.cpp).
constexpr double kPredictorShare = 1e-5;
constexpr double kLargestTurn = 0.5;
constexpr double kLargestStep = 0.1;      // in widths of the receiver
constexpr double kTrust = 0.05;           // of a step, by which the corrector may move it
constexpr double kShortestStep = 1e-13;   // in widths
constexpr double kLeastArcError = 1e-14;  // in widths
constexpr double kFirstStep = 1e-3;       // in widths
constexpr int kMaxCorrections = 12;
constexpr double kUsedChord = 0.8;
constexpr int kMaxSplits = 40;
// An arc meets a node that its polynomial passes within this share of the step; it has to pass it
// within kNodeShare of the receiver's width after correction.
constexpr double kNearNode = 1e-2;
constexpr double kNodeShare = 1e-8;
// Where rounding blurs the level, by this many times what it left on the way.
constexpr double kBlurs = 8.0;
// Where E hardly varies its residual does not tell the place: this share of the width is to do so.
constexpr double kPlaceShare = 1e-10;

// The nodes on both sides of a boundary at which a sheet begins with E = 0 are this near to each
// other, in widths of the receiver.
constexpr double kFadeShare = 1e-7;
// Places of a level this near to an arc, in chord tolerances, are on it.
constexpr double kSameArc = 1e-2;
// A search along an arc has ended that moves by this share of what counts as the same place.
constexpr double kStandingStill = 1e-3;
// Nodes lie on their level to this.
constexpr double kNodeResidual = 1e-9;

// Brighter side on the left.
Vec2 along_level(const Total& total) {
  return Vec2(total.gradient.y(), -total.gradient.x()).normalized();
}

}  // namespace

struct ArcNode {
  ArcVertex at;
  Vec2 t;          // unit tangent
  double s = 0.0;  // since the beginning of the step
};

class ArcTracer::Impl final : public DirectionField {
 public:
  Impl(SheetCarrier& carrier, const ArcOptions& options, Budget& budget)
      : carrier_(carrier),
        options_(options),
        budget_(budget),
        width_(carrier.system().receiver().width()),
        predictor_(*this) {}

  LevelArc follow(const Vec2& q, const Branches& branches, std::vector<TotalNode>& ends);

  bool direction(const Point& p, Vec3& t) override {
    Branches there = from_->branches;
    if (!carrier_.carry(there, Vec2(p.x(), p.y()))) return false;
    const Vec2 along = along_level(total_of(there));
    t = Vec3(along.x(), along.y(), 0.0);
    return along.allFinite();
  }
  bool direction_at_end(const Point& p, Vec3& t) override {
    arrived_ = correct(Vec2(p.x(), p.y()), from_->branches, kTrust * step_);
    if (arrived_) t = Vec3(arrived_->t.x(), arrived_->t.y(), 0.0);
    return arrived_.has_value();
  }

 private:
  std::optional<ArcNode> correct(const Vec2& start, const Branches& from, double trust);
  CurvePlace place(const ArcNode& a) const;
  std::optional<ArcNode> advance(const ArcNode& from);
  std::optional<ArcNode> between(const ArcNode& a, const ArcNode& b, double s);
  double split(const ArcNode& a, const ArcNode& b) const;
  double near_node() const { return kNodeShare * width_ + kBlurs * blur_; }
  std::optional<double> meets(const ArcNode& a, const ArcNode& b, const Vec2& node) const;
  std::optional<double> passes(const ArcNode& a, const ArcNode& b, const Vec2& node);
  bool accept(const ArcNode& a, const ArcNode& b, std::vector<TotalNode>& ends, LevelArc& arc);

  SheetCarrier& carrier_;
  ArcOptions options_;
  Budget& budget_;
  double width_;
  Predictor predictor_;
  const ArcVertex* from_ = nullptr;  // what stages are carried from
  std::optional<ArcNode> arrived_;
  StepLength length_;
  double step_ = 0.0;  // the last that was tried
  double blur_ = 0.0;  // how far from the level rounding left a place of this arc, m
  ArcNode start_;
  PassedPlaces passed_;  // vertices before the last one
};

// Newton's method along ∇E, all sheets carried from a place nearby.
std::optional<ArcNode> ArcTracer::Impl::correct(const Vec2& start, const Branches& from,
                                                double trust) {
  Vec2 q = start;
  Branches branches = from;
  double previous = geometry::kInfinity;
  for (int i = 0; i < kMaxCorrections; ++i) {
    if (!carrier_.carry(branches, q)) return std::nullopt;
    const Total total = total_of(branches);
    const double residual = std::abs(total.E / options_.level - 1.0);
    const double off = std::abs(options_.level - total.E) / total.gradient.norm();
    const bool there = residual <= options_.residual && off <= kPlaceShare * width_;
    const bool as_near_as_can_be = i > 3 && residual >= 0.5 * previous && residual < kLevelNoise;
    if (!there && as_near_as_can_be) blur_ = std::max(blur_, off);
    if (there || as_near_as_can_be)
      return ArcNode{{q, std::move(branches)}, along_level(total), 0.0};
    previous = residual;
    q += ((options_.level - total.E) / total.gradient.squaredNorm()) * total.gradient;
    if (!((q - start).norm() <= trust)) return std::nullopt;
  }
  return std::nullopt;
}

std::optional<ArcNode> ArcTracer::Impl::advance(const ArcNode& from) {
  from_ = &from.at;
  while (length_.now() > kShortestStep * width_) {
    step_ = length_.now();
    const Point p(from.at.q.x(), from.at.q.y(), 0.0);
    const auto step = predictor_.attempt(p, Vec3(from.t.x(), from.t.y(), 0.0), step_);
    if (!step.usable) {
      length_.failed();
      continue;
    }
    const double allowed = std::max(kPredictorShare * step_, kLeastArcError * width_);
    const double turn = std::acos(std::clamp(from.t.dot(arrived_->t), -1.0, 1.0));
    const double room = StepLength::room(turn, kLargestTurn, step_, kLargestStep * width_);
    if (length_.judge(step.error, allowed, room)) {
      ArcNode to = *arrived_;
      to.s = step_;
      return to;
    }
  }
  return std::nullopt;
}

// Where Newton's next step leads from a place that is kept as it is, if rounding lets it say so.
CurvePlace ArcTracer::Impl::place(const ArcNode& a) const {
  const Total total = total_of(a.at.branches);
  const Vec2 step = ((options_.level - total.E) / total.gradient.squaredNorm()) * total.gradient;
  const Vec2 q = step.norm() <= kPlaceShare * width_ ? Vec2(a.at.q + step) : a.at.q;
  return {Point(q.x(), q.y(), 0.0), Vec3(a.t.x(), a.t.y(), 0.0)};
}

std::optional<ArcNode> ArcTracer::Impl::between(const ArcNode& a, const ArcNode& b, double s) {
  const Point p = passed_.predict(place(a), place(b), predictor_.at(s / step_), step_);
  auto at = correct(Vec2(p.x(), p.y()), a.at.branches, (b.at.q - a.at.q).norm());
  if (at) at->s = s;
  return at;
}

double ArcTracer::Impl::split(const ArcNode& a, const ArcNode& b) const {
  const double ds = b.s - a.s;
  const double error = chord_error(a.at.q, b.at.q, ds * a.t, ds * b.t) / options_.chord;
  if (error <= kUsedChord) return 1.0;
  return 1.0 / std::clamp(std::ceil(std::sqrt(error / kUsedChord)), 2.0, 64.0);
}

// Arc at which the polynomial between a and b passes near `node`, if it does.
std::optional<double> ArcTracer::Impl::meets(const ArcNode& a, const ArcNode& b,
                                             const Vec2& node) const {
  const double ds = b.s - a.s;
  const Vec2 chord = b.at.q - a.at.q;
  // Along the cubic through both ends, by its chord's share.
  double w = std::clamp(chord.dot(node - a.at.q) / chord.squaredNorm(), -0.01, 1.01);
  for (int i = 0; i < 6; ++i) {
    const double v = 1.0 - w;
    const Vec2 q = a.at.q + (w * w * (3.0 - 2.0 * w)) * chord + (w * v * v * ds) * a.t -
                   (w * w * v * ds) * b.t;
    w = std::clamp(w + chord.dot(node - q) / chord.squaredNorm(), -0.01, 1.01);
  }
  const double v = 1.0 - w;
  const Vec2 q =
      a.at.q + (w * w * (3.0 - 2.0 * w)) * chord + (w * v * v * ds) * a.t - (w * w * v * ds) * b.t;
  if (!((q - node).norm() <= kNearNode * ds + near_node())) return std::nullopt;
  if (w <= 0.0) return (node - a.at.q).norm() <= near_node() ? std::optional(a.s) : std::nullopt;
  return std::min(b.s, a.s + w * ds);
}

// Arc at which the exact curve passes it.
std::optional<double> ArcTracer::Impl::passes(const ArcNode& a, const ArcNode& b,
                                              const Vec2& node) {
  const auto s = meets(a, b, node);
  if (!s) return std::nullopt;
  const auto at = between(a, b, std::clamp(*s, 0.0, step_));
  if (!at) return std::nullopt;
  const Vec2 gap = node - at->at.q;
  const double off = std::abs(at->t.x() * gap.y() - at->t.y() * gap.x());
  const double bend = 0.5 * gap.squaredNorm() / std::max(length_.now(), kShortestStep * width_);
  return off <= near_node() + bend ? s : std::nullopt;
}

// Takes the piece from a to b, unless the arc ends on it or closes.
bool ArcTracer::Impl::accept(const ArcNode& a, const ArcNode& b, std::vector<TotalNode>& ends,
                             LevelArc& arc) {
  std::optional<std::size_t> end;
  double first = geometry::kInfinity;
  for (std::size_t k = 0; k < ends.size(); ++k) {
    // Where a sheet fades out the arc on the other side ends just where this one begins.
    if (arc.vertices.size() == 1 && (ends[k].q - arc.vertices[0].q).norm() <= kFadeShare * width_)
      continue;
    const auto s = passes(a, b, ends[k].q);
    if (!s || *s >= first) continue;
    first = *s;
    end = k;
  }
  if (end) {
    arc.vertices.push_back({ends[*end].q, ends[*end].branches});
    ends.erase(ends.begin() + static_cast<std::ptrdiff_t>(*end));
    return true;
  }
  if (arc.vertices.size() > 4) {
    const double before = start_.t.dot(a.at.q - start_.at.q),
                 after = start_.t.dot(b.at.q - start_.at.q);
    if (before < 0.0 && after >= 0.0 && passes(a, b, start_.at.q)) {
      arc.closed = true;
      return true;
    }
  }
  arc.vertices.push_back(b.at);
  budget_.spend_vertices(1);
  return false;
}

LevelArc ArcTracer::Impl::follow(const Vec2& q, const Branches& branches,
                                 std::vector<TotalNode>& ends) {
  LevelArc arc;
  arc.vertices.push_back({q, branches});
  length_ = StepLength(kFirstStep * width_);
  blur_ = 0.0;
  passed_.clear();
  // A start inside a face lies on the level to a share of a cell only.
  from_ = &arc.vertices.front();
  if (std::abs(total_of(branches).E / options_.level - 1.0) > kNodeResidual) {
    const auto on_level = correct(q, branches, length_.now());
    arc.stalled = !on_level;
    if (arc.stalled) return arc;
    if ((on_level->at.q - q).norm() > near_node()) arc.vertices.front() = on_level->at;
  }
  start_ = {arc.vertices.front(), along_level(total_of(arc.vertices.front().branches)), 0.0};
  ArcNode a = start_;
  while (!budget_.exhausted()) {
    auto b = advance(a);
    if (!b) break;
    a.s = 0.0;
    std::vector<ArcNode> pending{std::move(*b)};
    while (!pending.empty()) {
      const double w = pending.size() < kMaxSplits ? split(a, pending.back()) : 1.0;
      if (w < 1.0) {
        auto c = between(a, pending.back(), a.s + w * (pending.back().s - a.s));
        if (c && c->s > a.s && c->s < pending.back().s) {
          pending.push_back(std::move(*c));
          continue;
        }
      }
      if (accept(a, pending.back(), ends, arc)) return arc;
      passed_.remember(place(a), Point(pending.back().at.q.x(), pending.back().at.q.y(), 0.0));
      a = std::move(pending.back());
      pending.pop_back();
    }
  }
  arc.stalled = true;
  return arc;
}

ArcTracer::ArcTracer(SheetCarrier& carrier, const ArcOptions& options, Budget& budget)
    : impl_(std::make_unique<Impl>(carrier, options, budget)) {}
ArcTracer::~ArcTracer() = default;

LevelArc ArcTracer::follow(const Vec2& q, const Branches& branches, std::vector<TotalNode>& ends) {
  return impl_->follow(q, branches, ends);
}

// From the cubic between two vertices along ∇E onto the level and along the level towards q, in
// turn. What is so near to the cubic is taken for the arc's: next to a caustic the cubic may lie
// beyond it.
bool on_arc(SheetCarrier& carrier, const LevelArc& arc, double level, const Vec2& q, double chord) {
  const double same = kNodeShare * carrier.system().receiver().width();
  const auto passes = [&](const ArcVertex& a, const ArcVertex& b) {
    const Vec2 way = b.q - a.q;
    const double w = std::clamp((q - a.q).dot(way) / way.squaredNorm(), 0.0, 1.0), v = 1.0 - w;
    if (!((a.q + w * way - q).norm() <= 2.0 * chord + same)) return false;
    const Vec2 t_a = along_level(total_of(a.branches)), t_b = along_level(total_of(b.branches));
    Vec2 p =
        a.q + w * w * (3.0 - 2.0 * w) * way + way.norm() * ((w * v * v) * t_a - (w * w * v) * t_b);
    if ((p - q).norm() <= kSameArc * chord) return true;
    Branches there = w < 0.5 ? a.branches : b.branches;
    for (int i = 0; i < kMaxCorrections; ++i) {
      if (!p.allFinite() || !carrier.carry(there, p)) return false;
      const Total total = total_of(there);
      const Vec2 onto = (level - total.E) / total.gradient.squaredNorm() * total.gradient;
      const Vec2 along = along_level(total), step = onto + along * along.dot(q - p - onto);
      p += step;
      if ((p - q).norm() <= same) return true;
      if (step.norm() <= kStandingStill * same) return false;
    }
    return false;
  };
  const auto& v = arc.vertices;
  for (std::size_t i = 1; i < v.size(); ++i) {
    if (passes(v[i - 1], v[i])) return true;
  }
  return arc.closed && passes(v.back(), v.front());
}

bool begins_arc(const TotalNode& node) {
  return along_level(total_of(node.branches)).dot(node.into) > 0.0;
}

}  // namespace caustic::solver
