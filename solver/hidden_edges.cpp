#include "solver/hidden_edges.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "solver/corrector.h"
#include "solver/visibility_brackets.h"

namespace caustic::solver {

namespace {

// Before a bracket tells what hides it is halved so many times, and again where that failed.
constexpr int kNarrowings = 10;
constexpr int kNarrowingRounds = 4;
// A corner is located to this share of a circle about it; what takes over there from a curve is
// looked for so far beyond, too, as a share of the scene.
constexpr double kCornerPlace = 1.0 / 30.0;
constexpr int kCornerSteps = 60;
constexpr double kBeyondCorner = 1e-3;
// Edges that are looked for at one place reach at least so far, in widths of the receiver.
constexpr double kLikelyReach = 0.02;
// An edge is kept so many chord tolerances beyond its corners.
constexpr double kOverhang = 4.0;
// What an edge remembers lies this share of the cell that it was found in apart.
constexpr double kMemorySpacing = 0.1;
// The way by a curve's point is longer than its chord by no more than this share.
constexpr double kDetour = 0.1;
// Edges of the same kind on which the same place lies to this share of the scene are one.
constexpr double kSameEdge = 1e-9;
// Places of an edge from which the other edge of a sliver is sought.
constexpr std::size_t kPlacesAcross = 3;
// Newton's way to an edge, in lengths of its bracket.
constexpr double kBracketTrust = 3.0;

// A curve, and at which of its vertices it bounds what is seen.
struct Walked {
  BoundaryCurve curve;
  std::vector<char> real;
  bool of_domain = false;  // it lies on an edge of the domain, which stands for it
  std::size_t segments() const { return curve.own.size() - !curve.closed; }
  std::size_t next(std::size_t i) const { return (i + 1) % curve.own.size(); }
  /// The segment whose ends are joined by way of x with the least detour, m.
  struct Nearest {
    std::size_t segment;
    double detour;
  };
  Nearest nearest(const Point& x) const {
    Nearest best{0, geometry::kInfinity};
    for (std::size_t i = 0; i < segments(); ++i) {
      const Point &a = curve.own[i].x, &b = curve.own[next(i)].x;
      const double detour = (x - a).norm() + (b - x).norm() - (b - a).norm();
      if (detour < best.detour) best = {i, detour};
    }
    return best;
  }
};

class HiddenEdgeFinder {
 public:
  HiddenEdgeFinder(SheetCarrier& carrier, int field, std::vector<BoundaryCurve>& curves,
                   Budget& budget, double chord, double residual)
      : carrier_(carrier),
        index_(field),
        field_(carrier.field(field)),
        evaluate_(carrier.evaluator(field)),
        search_(carrier, field),
        curves_(curves),
        budget_(budget),
        chord_(chord),
        residual_(residual),
        diameter_(carrier.system().diameter()) {}

  std::size_t run(const std::vector<Point>& likely) {
    search_.of_cells(budget_, brackets_);
    if (field_.piece.hops.empty()) search_.of_shadows(brackets_);
    const double reach = kLikelyReach * carrier_.system().receiver().width();
    for (const Point& x : likely) search_.around(evaluate_.on_surface(x), reach, {}, brackets_);
    for (const BoundaryCurve& curve : curves_) walk({curve, {}, false});
    for (std::size_t b = 0; b < brackets_.size() && !budget_.exhausted(); ++b) {
      take(Bracket(brackets_[b]));
    }
    for (const Walked& edge : edges_) {
      if (!edge.of_domain) keep_real(edge);
    }
    return unexplained_;
  }

 private:
  Walked walk(Walked edge);
  void find_corner(const BoundaryCurve& curve, FieldPoint a, FieldPoint b, bool real_at_a);
  void keep_real(const Walked& edge);
  void take(Bracket bracket);
  void look_across(const Walked& edge, double reach);
  void narrow(Bracket& bracket);
  bool known(const Bracket& bracket);
  bool known(const HiddenEdge& edge, const FieldPoint& at) const;
  bool add_vertex(Walked& edge, const Bracket& bracket);
  std::vector<std::shared_ptr<HiddenEdge>> candidates(const Bracket& bracket) const;
  bool trace(const std::shared_ptr<HiddenEdge>& edge, const Bracket& bracket);

  SheetCarrier& carrier_;
  int index_;
  const FamilyField& field_;
  Evaluator& evaluate_;
  BracketSearch search_;
  std::vector<BoundaryCurve>& curves_;
  std::vector<Walked> edges_;  // also where they hide nothing
  Budget& budget_;
  double chord_, residual_, diameter_;
  std::vector<Bracket> brackets_;
  std::size_t unexplained_ = 0;  // brackets of which no surface's edge was found
};

// Corners are where along a curve it begins or ceases to bound what is seen.
Walked HiddenEdgeFinder::walk(Walked edge) {
  if (edge.of_domain) return edge;
  for (const FieldPoint& f : edge.curve.own)
    edge.real.push_back(!budget_.out_of_time() && opening_at(carrier_, edge.curve, f).real);
  for (std::size_t i = 0; i < edge.segments() && !budget_.exhausted(); ++i) {
    const std::size_t next = edge.next(i);
    if (edge.real[i] != edge.real[next])
      find_corner(edge.curve, edge.curve.own[i], edge.curve.own[next], edge.real[i]);
  }
  return edge;
}

void HiddenEdgeFinder::find_corner(const BoundaryCurve& curve, FieldPoint a, FieldPoint b,
                                   bool real_at_a) {
  const double length = (b.x - a.x).norm(), place = kCornerPlace * search_.radius();
  const double reach = std::min(length, kLikelyReach * carrier_.system().receiver().width());
  const Vec3 beyond = (real_at_a ? 1.0 : -1.0) / length * (b.x - a.x);
  for (int k = 0; k < kCornerSteps && (b.x - a.x).norm() > place; ++k) {
    const auto middle =
        correct(evaluate_, curve.function(field_), 0.5 * (a.x + b.x), {residual_}, a.hits.get());
    if (!middle) break;
    (opening_at(carrier_, curve, *middle).real == real_at_a ? a : b) = *middle;
  }
  search_.around(a, reach, beyond, brackets_);
  // What takes over may touch the curve there, and is told from it further on.
  const double on = kBeyondCorner * diameter_;
  if (const auto next = on < length ? correct(evaluate_, curve.function(field_), a.x + on * beyond,
                                              {residual_}, a.hits.get())
                                    : std::nullopt)
    search_.around(*next, reach, beyond, brackets_);
}

// Runs of vertices at which the edge is real, with as much more at either end that corners are on
// it.
void HiddenEdgeFinder::keep_real(const Walked& edge) {
  const BoundaryCurve& curve = edge.curve;
  const std::vector<char>& real = edge.real;
  const std::size_t n = real.size();
  std::vector<char> kept = real;
  for (std::size_t i = 0; i < n; ++i) {
    if (!real[i]) continue;
    for (const std::size_t step : {std::size_t{1}, n - 1}) {
      for (std::size_t j = (i + step) % n; !real[j]; j = (j + step) % n) {
        const bool round_the_end = (j + n - step) % n != (step == 1 ? j - 1 : j + 1);
        if (round_the_end && !curve.closed) break;
        kept[j] = true;
        if ((curve.q[j] - curve.q[i]).norm() > kOverhang * chord_) break;
      }
    }
  }
  const auto gap = static_cast<std::size_t>(std::find(kept.begin(), kept.end(), 0) - kept.begin());
  if (gap == n) return curves_.push_back(curve);
  // Once round a closed curve from a gap.
  const std::size_t begin = curve.closed ? gap : 0;
  BoundaryCurve run{curve.kind, curve.field, curve.boundary, false, {}, {}, curve.edge};
  for (std::size_t i = begin; i <= begin + n; ++i) {
    if (i < begin + n && kept[i % n]) {
      run.q.push_back(curve.q[i % n]);
      run.own.push_back(curve.own[i % n]);
    } else if (!run.q.empty()) {
      if (run.q.size() > 1) curves_.push_back(run);
      run.q.clear();
      run.own.clear();
    }
  }
}

void HiddenEdgeFinder::narrow(Bracket& bracket) {
  for (int k = 0; k < kNarrowings; ++k) {
    FieldPoint middle = evaluate_.on_surface(0.5 * (bracket.visible.x + bracket.hidden.x),
                                             bracket.visible.hits.get());
    if (!middle.arrives()) return;
    (search_.hidden(middle) ? bracket.hidden : bracket.visible) = std::move(middle);
  }
}

// Does an edge that has been traced pass between? If so it is real there, which no vertex may have
// told.
bool HiddenEdgeFinder::known(const Bracket& bracket) {
  const Point middle = 0.5 * (bracket.visible.x + bracket.hidden.x);
  const double length = (bracket.visible.x - bracket.hidden.x).norm();
  for (Walked& edge : edges_) {
    const auto [i, detour] = edge.nearest(middle);
    const double chord = (edge.curve.own[edge.next(i)].x - edge.curve.own[i].x).norm();
    if (detour > kDetour * chord + 2.0 * length) continue;
    const HiddenEdge& h = *edge.curve.edge;
    if (h.value(bracket.visible) * h.value(bracket.hidden) > 0.0) continue;
    // Where it is none, another edge passes there too.
    if (edge.of_domain || edge.real[i] || edge.real[edge.next(i)] || add_vertex(edge, bracket))
      return true;
  }
  return false;
}

// The same of a place on an edge.
bool HiddenEdgeFinder::known(const HiddenEdge& edge, const FieldPoint& at) const {
  for (const Walked& other : edges_) {
    const HiddenEdge& h = *other.curve.edge;
    if (!h.hiding().same_function(edge.hiding())) continue;
    const auto [i, detour] = other.nearest(at.x);
    const double chord = (other.curve.own[other.next(i)].x - other.curve.own[i].x).norm();
    if (detour <= kDetour * chord && std::abs(h.value(at)) <= kSameEdge * diameter_) return true;
  }
  return false;
}

// False if the edge is none there.
bool HiddenEdgeFinder::add_vertex(Walked& edge, const Bracket& bracket) {
  const auto at = correct(evaluate_, edge.curve.function(field_), bracket.visible, {residual_});
  if (!at || !opening_at(carrier_, edge.curve, *at).real) return false;
  const std::size_t i = edge.nearest(at->x).segment;
  if (edge.real[i] || edge.real[edge.next(i)]) return true;
  const FieldPoint before = edge.curve.own[i], after = edge.curve.own[edge.next(i)];
  const auto where = static_cast<std::ptrdiff_t>(i) + 1;
  edge.curve.q.insert(edge.curve.q.begin() + where, at->q);
  edge.curve.own.insert(edge.curve.own.begin() + where, *at);
  edge.real.insert(edge.real.begin() + where, true);
  find_corner(edge.curve, before, *at, false);
  find_corner(edge.curve, after, *at, false);
  return true;
}

// What may be about to hide the path: each way in which each surface that hides the one may.
std::vector<std::shared_ptr<HiddenEdge>> HiddenEdgeFinder::candidates(
    const Bracket& bracket) const {
  std::vector<std::shared_ptr<HiddenEdge>> all;
  const auto& surfaces = carrier_.system().surfaces();
  const Hops& hops = field_.piece.hops;
  const int last = static_cast<int>(hops.size()) + 1;
  for (const auto& m : field_.visibility->meetings(hops, LightPath(field_.map, bracket.hidden))) {
    if (m.margin > 0.0) continue;
    const auto add = [&](Hiding hiding) {
      auto edge = std::make_shared<HiddenEdge>(field_.map, hiding, bracket.hidden, m.y,
                                               kMemorySpacing * bracket.reach);
      if (edge->value(bracket.visible) * edge->value(bracket.hidden) <= 0.0)
        all.push_back(std::move(edge));
    };
    const auto add_points = [&] {
      for (const int k : {m.segment, m.segment + 1}) {
        if (k == 0 || (k < last && hops[k - 1].surface == m.surface)) continue;
        add({Hiding::Kind::point, m.segment, m.surface, nullptr, k});
      }
    };
    // A rim may lie on the receiver, and is where the surface meets it then.
    if (hops.empty()) add_points();
    for (const auto& bound : surfaces[m.surface].bounds)
      add({Hiding::Kind::rim, m.segment, m.surface, &bound});
    add({Hiding::Kind::touch, m.segment, m.surface});
    if (!hops.empty()) add_points();
  }
  return all;
}

bool HiddenEdgeFinder::trace(const std::shared_ptr<HiddenEdge>& edge, const Bracket& bracket) {
  const double length = (bracket.visible.x - bracket.hidden.x).norm();
  const auto function = LevelFunction::edge_of(*edge);
  const auto at = correct(evaluate_, function, bracket.visible,
                          {residual_, geometry::kInfinity, kBracketTrust * length});
  if (!at) return false;
  BoundaryCurve probe{kind_of(edge->ending()), index_, -1, false, {}, {}, edge};
  if (!opening_at(carrier_, probe, *at).real) return false;
  if (known(*edge, *at)) return true;
  // Where it hides nothing it may end anyhow.
  auto found = curves_along(carrier_, index_, kind_of(edge->ending()), function,
                            {Seed{0, *at, bracket.reach}}, budget_, chord_, residual_);
  for (BoundaryCurve& curve : found.curves) {
    curve.edge = edge;
    const bool of_domain = coincides_with_domain(field_, curve);
    edges_.push_back(walk({std::move(curve), {}, of_domain}));
    if (!of_domain) look_across(edges_.back(), bracket.reach);
  }
  return true;
}

// What is hidden may be a sliver that no samples are in: from some places of its edge across it, in
// steps twice as long as the one before, to where something is seen again.
void HiddenEdgeFinder::look_across(const Walked& edge, double reach) {
  const std::size_t n = edge.curve.own.size(), step = n / (kPlacesAcross + 1) + 1;
  for (std::size_t i = step; i < n && !budget_.out_of_time(); i += step) {
    if (!edge.real[i]) continue;
    const FieldPoint& at = edge.curve.own[i];
    const Vec3 across = -opening_at(carrier_, edge.curve, at).inside;
    std::optional<FieldPoint> before;
    for (double way = kOpeningStep * diameter_; way < reach; way *= 2.0) {
      FieldPoint f = evaluate_.on_surface(at.x + way * across, at.hits.get());
      if (!f.arrives() || field_.domain.worst(f).value > 0.0) break;
      if (search_.hidden(f)) {
        before = std::move(f);
      } else {
        if (before) brackets_.push_back({std::move(f), *before, reach});
        break;
      }
    }
  }
}

void HiddenEdgeFinder::take(Bracket bracket) {
  if (known(bracket)) return;
  for (int round = 0; round < kNarrowingRounds; ++round) {
    narrow(bracket);
    if (known(bracket)) return;
    for (const auto& edge : candidates(bracket)) {
      if (trace(edge, bracket)) return;
    }
  }
  ++unexplained_;
}

}  // namespace

std::size_t add_hidden_edges(SheetCarrier& carrier, int field, const std::vector<Point>& likely,
                             std::vector<BoundaryCurve>& curves, Budget& budget, double chord,
                             double residual) {
  return HiddenEdgeFinder(carrier, field, curves, budget, chord, residual).run(likely);
}

}  // namespace caustic::solver
