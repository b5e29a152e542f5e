// Surfaces given by an expression. Lengths of the field are metres in its own frame; the pose leads
// to the world, for the field and its bounds together.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "geometry/expression/field.h"
#include "geometry/expression/leaves.h"
#include "geometry/ray_polynomial.h"
#include "geometry/rotated_third.h"
#include "geometry/surface.h"

namespace caustic::geometry {

namespace {

/// Rays are followed this share of the bounds' diagonal beyond them: a crossing that moves out of
/// the bounds does not vanish at once.
constexpr double kBeyondBounds = 0.1;

// g along a ray from its derivative of order `first` on, with ranges that mean values narrow (S17).
class AlongRay {
 public:
  AlongRay(const Field& field, const Ray& ray, int first)
      : field_(field), ray_(ray), first_(first) {}

  double f(double t) const { return derivative(t, 0); }
  double df(double t) const { return derivative(t, 1); }
  double ddf(double t) const { return derivative(t, 2); }
  Interval range_f(double a, double b) const { return range(a, b, 0); }
  Interval range_df(double a, double b) const { return range(a, b, 1); }
  Interval range_ddf(double a, double b) const {
    std::array<Interval, 4> out;
    const bool defined = field_.along(ray_, Interval(a, b), first_ + 2, out.data());
    return defined ? out[static_cast<std::size_t>(first_ + 2)] : Interval::whole();
  }

 private:
  double derivative(double t, int order) const {
    std::array<double, 4> out;
    field_.along(ray_, t, first_ + order, out.data());
    return out[static_cast<std::size_t>(first_ + order)];
  }
  // The derivative of that order. Where it is not defined throughout, its values still count, but
  // no sign of a slope says that it is monotone.
  Interval range(double a, double b, int order) const {
    const auto n = static_cast<std::size_t>(first_ + order);
    const Interval t(a, b);
    std::array<Interval, 4> out, middle;
    const bool defined = field_.along(ray_, t, first_ + order, out.data());
    const Interval natural = out[n];
    if (!defined) return order == 0 ? natural : Interval::whole();
    if (!natural.contains_zero() || !field_.along(ray_, t, first_ + order + 1, out.data())) {
      return natural;
    }
    const double m = t.middle();
    field_.along(ray_, Interval(m), first_ + order, middle.data());
    return intersection(natural, middle[n] + out[n + 1] * (t - m));
  }

  const Field& field_;
  const Ray& ray_;
  int first_;
};

class ExpressionSurface final : public Surface {
 public:
  ExpressionSurface(std::shared_ptr<const Field> field, const Box& box, const Pose& pose,
                    Leaves leaves)
      : field_(std::move(field)), box_(box), pose_(pose), leaves_(std::move(leaves)) {
    if (!field_->third_derivative_vanishes()) return;
    Vec3 gradient;
    Mat3 hessian;
    field_->derivatives(box_.center(), gradient, hessian);
    const Vec3 bends =
        Eigen::SelfAdjointEigenSolver<Mat3>(hessian, Eigen::EigenvaluesOnly).eigenvalues();
    convex_ = {(bends.array() <= 0.0).all(), (bends.array() >= 0.0).all()};
  }

  double value(const Point& x) const override { return field_->value(local(x)); }
  double value_gradient(const Point& x, Vec3& gradient) const override {
    const double g = field_->value_gradient(local(x), gradient);
    gradient = pose_.direction(gradient);
    return g;
  }
  SurfaceDerivatives derivatives(const Point& x) const override {
    SurfaceDerivatives d;
    d.g = field_->derivatives(local(x), d.gradient, d.hessian);
    d.gradient = pose_.direction(d.gradient);
    d.hessian = pose_.rotation * d.hessian * pose_.rotation.transpose();
    return d;
  }
  Vec3 third_derivative(const Point& x, const Vec3& u, const Vec3& v) const override {
    if (field_->third_derivative_vanishes()) return Vec3::Zero();
    const Mat3& R = pose_.rotation;
    return R * field_->third_derivative(local(x), R.transpose() * u, R.transpose() * v);
  }
  ThirdDerivatives third_derivatives(const Point& x, const Vec3& u, const Vec3& v) const override {
    if (field_->third_derivative_vanishes()) return {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    const Mat3& R = pose_.rotation;
    const auto T = field_->third_derivatives(local(x), R.transpose() * u, R.transpose() * v);
    return {R * T[0], R * T[1], R * T[2]};
  }
  SurfaceEnclosure enclose(const IntervalVec3& x) const override {
    SurfaceEnclosure e;
    if (aligned_) {
      if (!field_->enclose(x - pose_.translation, e)) undefined_slopes(e);
      return e;
    }
    if (!field_->enclose(transposed(pose_.rotation, x - pose_.translation), e)) {
      undefined_slopes(e);
    }
    return rotated(e, pose_.rotation);
  }
  IntervalSym333 enclose_third(const IntervalVec3& x) const override {
    IntervalSym333 third;
    const IntervalVec3 y = transposed(pose_.rotation, x - pose_.translation);
    if (!field_->enclose_third(y, third)) third.fill(Interval::whole());
    return aligned_ ? third : rotated(third, pose_.rotation);
  }
  bool at_most_quadratic() const override { return field_->third_derivative_vanishes(); }

  void crossings(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    find(ray, Along::crossings, t0, t1, out);
  }
  void stationary(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    find(ray, Along::stationary, t0, t1, out);
  }

  bool convex(int side) const override { return convex_[side > 0 ? 1 : 0]; }
  Box bounds() const override {
    Box box{Point::Constant(kInfinity), Point::Constant(-kInfinity)};
    for (const Leaf& leaf : leaves_.graphs) include(box, leaf.box);
    for (const Box& undecided : leaves_.undecided) include(box, undecided);
    return box;
  }
  std::vector<Bound> own_bounds() const override {
    std::vector<Bound> bounds;
    for (int k = 0; k < 3; ++k) append_slab(bounds, box_, k);
    return bounds;
  }
  std::vector<Chart> charts(const Extent& extent) const override {
    std::vector<Chart> charts;
    for (const Leaf& leaf : leaves_.graphs) {
      Box world{Point::Constant(kInfinity), Point::Constant(-kInfinity)};
      include(world, leaf.box);
      if (world.intersected(extent.region).empty()) continue;
      Chart chart{[field = field_, pose = pose_, leaf](double s, double t) {
        return pose.point(graph_point(*field, leaf, s, t));
      }};
      append_slab(chart.cell, leaf.box, leaf.axis);
      charts.push_back(std::move(chart));
    }
    return charts;
  }

 private:
  // Where g is not defined throughout no slope bounds its changes.
  static void undefined_slopes(SurfaceEnclosure& e) {
    e.gradient.fill(Interval::whole());
    e.hessian.fill(Interval::whole());
  }
  Point local(const Point& x) const { return pose_.rotation.transpose() * (x - pose_.translation); }
  void include(Box& world, const Box& own) const {
    const Point center = pose_.point(own.center());
    const Vec3 reach = pose_.rotation.cwiseAbs() * (0.5 * (own.max - own.min));
    world = {world.min.cwiseMin(center - reach), world.max.cwiseMax(center + reach)};
  }
  // Both half-spaces of the slab of `own` across axis k.
  void append_slab(std::vector<Bound>& bounds, const Box& own, int k) const {
    for (const double sign : {1.0, -1.0}) {
      const Direction axis = pose_.direction(sign * Vec3::Unit(k));
      const Point face = pose_.point(sign > 0.0 ? own.max : own.min);
      bounds.push_back({Bound::Kind::half_space, face, axis, 0.0, Bound::Origin::shape});
    }
  }

  void find(const Ray& world, Along what, double t0, double t1, RayParameters& out) const {
    const Ray ray{local(world.origin), pose_.rotation.transpose() * world.direction};
    // Only where the ray passes near the bounds.
    const Vec3 margin = Vec3::Constant(kBeyondBounds * box_.diagonal());
    for (int k = 0; k < 3; ++k) {
      double near = (box_.min[k] - margin[k] - ray.origin[k]) / ray.direction[k];
      double far = (box_.max[k] + margin[k] - ray.origin[k]) / ray.direction[k];
      if (near > far) std::swap(near, far);
      if (near > t0) t0 = near;  // 0/0, a ray in the plane of a side, limits nothing
      if (far < t1) t1 = far;
    }
    if (!(t0 <= t1)) return;
    if (field_->quartic()) {
      roots_along([&](const Ray& r) { return field_->polynomial(r); }, ray, box_.center(), what, t0,
                  t1, out);
    } else {
      isolated_roots(AlongRay(*field_, ray, what == Along::stationary ? 1 : 0), t0, t1, out);
    }
  }

  std::shared_ptr<const Field> field_;
  Box box_;
  Pose pose_;
  Leaves leaves_;
  bool aligned_ = pose_.rotation == Mat3::Identity();
  std::array<bool, 2> convex_{false, false};
};

// Median of |∇g| at points of the surface, 0 if none is found.
double typical_slope(const Field& field, const Leaves& leaves) {
  constexpr int kAcross = 5;
  constexpr std::size_t kLeaves = 100;
  std::vector<double> slopes;
  const std::size_t stride = leaves.graphs.size() / kLeaves + 1;
  for (std::size_t n = 0; n < leaves.graphs.size(); n += stride) {
    const Leaf& leaf = leaves.graphs[n];
    for (int i = 0; i < kAcross; ++i) {
      for (int j = 0; j < kAcross; ++j) {
        const double s = (i + 0.5) / kAcross, t = (j + 0.5) / kAcross;
        if (!graph_exists(field, leaf, s, t)) continue;
        Vec3 gradient;
        field.value_gradient(graph_point(field, leaf, s, t), gradient);
        slopes.push_back(gradient.norm());
      }
    }
  }
  if (slopes.empty()) return 0.0;
  const auto middle = slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 2);
  std::nth_element(slopes.begin(), middle, slopes.end());
  return *middle;
}

}  // namespace

ExpressionResult make_expression(const Expression& expression, const Box& bounds,
                                 const Pose& pose) {
  const Field unscaled(expression, 1.0);
  Leaves leaves = cut_into_graphs(unscaled, bounds);
  if (!leaves.defined_somewhere) return {nullptr, "is undefined everywhere in its bounds", true};
  const double slope = typical_slope(unscaled, leaves);
  if (leaves.graphs.empty() && !leaves.undecided.empty()) {
    return {nullptr, "has no regular point in its bounds: its gradient vanishes on it", true};
  }
  if (!(slope > 0.0) || !std::isfinite(slope)) {
    return {nullptr, "the surface has no points in these bounds", false};
  }
  auto field = std::make_shared<const Field>(expression, 1.0 / slope);
  return {std::make_shared<ExpressionSurface>(std::move(field), bounds, pose, std::move(leaves)),
          "", false};
}

}  // namespace caustic::geometry
