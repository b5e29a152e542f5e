#include "solver/hidden_edge.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace caustic::solver {

namespace {

constexpr int kHiddenSteps = 20;
// A place that lies this share of the segment away from where it was last is another one.
constexpr double kOtherPlace = 0.1;
constexpr double kHiddenRoundings = 8.0;
// Far from a curved rim's edge the steps shrink only linearly. The distance is stationary in the
// place on the rim: a last step of this share of it leaves it right to the square of the share.
constexpr int kStepsBeforeShare = 7;
constexpr double kLastShareOfGap = 1e-7;
// Places this near to a limit, as a share of the scene and of the segment, are on it.
constexpr double kOnLimit = 1e-12;
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

}  // namespace

HiddenEdge::HiddenEdge(const ForwardMap& map, const Hiding& hiding, const FieldPoint& f,
                       const Point& y, double spacing)
    : map_(map), hiding_(hiding), reach_(map.system().reach(f.x)), spacing_(spacing) {
  const Point a = point_of_path(f, hiding.segment).at;
  const Vec3 D = point_of_path(f, hiding.segment + 1).at - a;
  const State guess = {f.x, D.dot(y - a) / D.squaredNorm(), y};
  last_ = solved(f, guess);
  known_.push_back(std::isfinite(last_.h) ? last_ : guess);
}

HiddenEdge::Moving HiddenEdge::point_of_path(const FieldPoint& f, int k) const {
  if (k == 0) {
    if (const auto* light = std::get_if<PointLight>(&map_.system().light()))
      return {light->position, Vec3::Zero(), Vec3::Zero()};
    const Direction& d = std::get<CollimatedLight>(map_.system().light()).direction;
    return {f.x - reach_ * d, f.e1, f.e2};
  }
  if (k == 1) return {f.x, f.e1, f.e2};
  if (k <= map_.hop_count()) return {f.hits[k - 1].y, f.hits[k - 1].y_s, f.hits[k - 1].y_t};
  const auto& r = map_.receiver();
  return {r.point(f.q), r.u * f.q_s.x() + r.v * f.q_s.y(), r.u * f.q_t.x() + r.v * f.q_t.y()};
}

// ∇g·D = 0 along the segment.
bool HiddenEdge::touch(const Moving& a, const Moving& b, State& state) const {
  const Vec3 D = b.at - a.at;
  for (int i = 0; i < kHiddenSteps; ++i) {
    state.y = a.at + state.t * D;
    const auto d = blocker().shape->derivatives(state.y);
    const double step = -d.gradient.dot(D) / D.dot(d.hessian * D);
    if (!std::isfinite(step)) return false;
    if (std::abs(step) <= kHiddenRoundings * geometry::kEpsilon * (1.0 + std::abs(state.t))) {
      state.h = d.g;
      const Vec3 slope_a = (1.0 - state.t) * d.gradient, slope_b = state.t * d.gradient;
      state.gradient =
          Vec3(slope_a.dot(a.s) + slope_b.dot(b.s), slope_a.dot(a.t) + slope_b.dot(b.t), 0);
      // ∂t* (S56).
      const Vec3 DH = d.hessian * D;
      const auto rate = [&](const Vec3& da, const Vec3& db) {
        return -(DH.dot((1.0 - state.t) * da + state.t * db) + d.gradient.dot(db - da)) / DH.dot(D);
      };
      state.gradient_t = Vec3(rate(a.s, b.s), rate(a.t, b.t), 0);
      return true;
    }
    state.t += step;
  }
  return false;
}

// The place y of the rim and the place r(t) of the segment that are nearest to each other: y − r is
// across the rim's tangent c = ∇g × ∇b and across D. Newton's method without the rim's curvature,
// which counts by the distance only, and that vanishes.
bool HiddenEdge::rim(const Moving& a, const Moving& b, State& state) const {
  const Vec3 D = b.at - a.at;
  const double size = D.norm() + state.y.norm();
  for (int i = 0; i < kHiddenSteps; ++i) {
    Vec3 grad_g;
    const double g = blocker().shape->value_gradient(state.y, grad_g);
    const Vec3 grad_b = hiding_.bound->gradient(state.y);
    const Vec3 c = grad_g.cross(grad_b), across = c.cross(D);
    const Point r = a.at + state.t * D;
    // y + δ on the rim; δ·c and dt from both orthogonalities.
    geometry::Mat3 rows;
    rows << grad_g.transpose(), grad_b.transpose(), c.transpose();
    const Vec3 onto = rows.inverse() * Vec3(-g, -hiding_.bound->value(state.y), 0.0);
    const Vec3 gap = state.y + onto - r;
    const double cc = c.squaredNorm(), cd = c.dot(D), dd = D.squaredNorm(), det = dd * cc - cd * cd;
    const double along_c = (-gap.dot(c) * dd + gap.dot(D) * cd) / det;
    const double dt = (gap.dot(D) * cc - gap.dot(c) * cd) / det;
    const Vec3 step = onto + along_c * c;
    if (!std::isfinite(dt) || !step.allFinite()) return false;
    state.y += step;
    state.t += dt;
    if (step.norm() + std::abs(dt) * D.norm() <= kHiddenRoundings * geometry::kEpsilon * size ||
        (i >= kStepsBeforeShare && step.norm() <= kLastShareOfGap * gap.norm())) {
      const Vec3 normal = across.normalized();
      state.h = normal.dot(state.y - a.at - state.t * D);
      const Vec3 slope_a = (state.t - 1.0) * normal, slope_b = -state.t * normal;
      state.gradient =
          Vec3(slope_a.dot(a.s) + slope_b.dot(b.s), slope_a.dot(a.t) + slope_b.dot(b.t), 0);
      return true;
    }
  }
  return false;
}

// From where the touch has moved to by ∂t* (S56), as far as that is to be trusted.
HiddenEdge::State HiddenEdge::solved(const FieldPoint& f, State guess) const {
  const double moved = guess.gradient_t.dot(f.x - guess.x);
  if (std::isfinite(moved)) guess.t += std::clamp(moved, -kOtherPlace, kOtherPlace);
  State state = guess;
  state.x = f.x;
  bool good = true;
  if (hiding_.kind == Hiding::Kind::point) {
    const Moving p = point_of_path(f, hiding_.point);
    Vec3 slope;
    state.y = p.at;
    state.h = blocker().shape->value_gradient(p.at, slope);
    state.gradient = Vec3(slope.dot(p.s), slope.dot(p.t), 0);
  } else {
    const Moving a = point_of_path(f, hiding_.segment), b = point_of_path(f, hiding_.segment + 1);
    good = hiding_.kind == Hiding::Kind::touch ? touch(a, b, state) : rim(a, b, state);
  }
  for (Vec3* slope : {&state.gradient, &state.gradient_t})
    *slope = slope->x() * f.e1 + slope->y() * f.e2;
  if (!good || std::abs(state.t - guess.t) > kOtherPlace) state.h = kNoNumber;
  return state;
}

const HiddenEdge::State& HiddenEdge::solve(const FieldPoint& f) const {
  if (last_.x == f.x) return last_;
  const State* nearest = &known_.front();
  double least = geometry::kInfinity;
  for (const State& state : known_) {
    const double d = (state.x - f.x).squaredNorm();
    if (d < least) least = d, nearest = &state;
  }
  last_ = solved(f, *nearest);
  if (std::isfinite(last_.h) && least > spacing_ * spacing_) known_.push_back(last_);
  return last_;
}

// Along the segment g has a minimum on the side where it is positive.
int HiddenEdge::side(const FieldPoint& f) const {
  const Point a = point_of_path(f, hiding_.segment).at;
  const Vec3 D = point_of_path(f, hiding_.segment + 1).at - a;
  const auto d = blocker().shape->derivatives(place(f));
  const double g_rises =
      hiding_.kind == Hiding::Kind::touch ? D.dot(d.hessian * D) : -d.gradient.dot(D);
  return g_rises > 0.0 ? 1 : -1;
}

bool HiddenEdge::possible(const FieldPoint& f) const {
  const State& state = solve(f);
  const double slack = kOnLimit * map_.system().diameter();
  if (hiding_.kind != Hiding::Kind::point && !(state.t > -kOnLimit && state.t < 1.0 + kOnLimit))
    return false;
  return std::all_of(blocker().bounds.begin(), blocker().bounds.end(), [&](const auto& bound) {
    return &bound == hiding_.bound || bound.value(state.y) <= slack;
  });
}

std::vector<double> HiddenEdge::limits(const FieldPoint& f) const {
  const State& state = solve(f);
  std::vector<double> all;
  for (const geometry::Bound& bound : blocker().bounds) {
    if (&bound != hiding_.bound) all.push_back(bound.value(state.y));
  }
  const Vec3 D = point_of_path(f, hiding_.segment + 1).at - point_of_path(f, hiding_.segment).at;
  if (hiding_.kind != Hiding::Kind::point) {
    all.push_back(state.t * D.norm());
    all.push_back((1.0 - state.t) * D.norm());
  }
  if (hiding_.kind != Hiding::Kind::touch) {
    Vec3 slope;
    blocker().shape->value_gradient(state.y, slope);
    all.push_back(slope.dot(D));
  }
  return all;
}

}  // namespace caustic::solver
