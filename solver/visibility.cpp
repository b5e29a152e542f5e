#include "solver/visibility.h"

#include <algorithm>
#include <cmath>

namespace caustic::solver {

using geometry::Ray;
using geometry::RayParameters;

namespace {

// A light or a receiver that touches a surface is not hidden by it: crossings this close to the far
// end of a segment, as a share of it, do not block.
constexpr double kLightEndShare = 1e-9;
constexpr double kReceiverEndShare = 1e-12;
// The crossing at the segment's own beginning is looked for within this share of it, and within so
// many roundings of its place.
constexpr double kOwnShare = 1e-7;
constexpr double kOwnRoundings = 1e3;

double margin_of(const std::vector<geometry::Bound>& bounds, const Point& x) {
  double worst = -geometry::kInfinity;
  for (const auto& bound : bounds) worst = std::max(worst, bound.value(x));
  return worst;
}

}  // namespace

Visibility::Visibility(const OpticalSystem& system, const geometry::EmbreeScene* candidates,
                       double margin)
    : system_(system), candidates_(candidates), margin_(margin) {}

Visibility::Sight Visibility::look(const ForwardMap& map, const FieldPoint& f) const {
  Segment to_light{{f.x, Vec3::Zero()}, 1.0 - kLightEndShare, false, map.surface_index()};
  if (const auto* point = std::get_if<PointLight>(&system_.light())) {
    to_light.ray.direction = point->position - f.x;
  } else {
    // Far enough to have passed every surface.
    double reach = 0.0;
    for (const auto& s : system_.surfaces()) {
      reach = std::max(reach, (s.region.center() - f.x).norm() + s.region.diagonal());
    }
    to_light.ray.direction = -reach * std::get<CollimatedLight>(system_.light()).direction;
  }
  const Segment to_receiver{{f.x, map.receiver().point(f.q) - f.x}, 1.0 - kReceiverEndShare, true,
                            map.surface_index()};
  const double lit = clearance(to_light);
  const double seen = clearance(to_receiver);
  if (lit < 0.0) return {lit, Ending::shadow};
  return {seen < 0.0 ? seen : std::min(lit, seen), seen < 0.0 || seen < lit ? Ending::occlusion
                                                                            : Ending::shadow};
}

double Visibility::clearance(const Segment& segment) const {
  double free = geometry::kInfinity, depth = 0.0;
  const auto ask = [&](int surface) {
    const double c = clearance(segment, surface);
    if (c < 0.0) depth = std::max(depth, -c);
    else free = std::min(free, c);
  };
  if (candidates_) {
    thread_local std::vector<int> found;
    found.clear();
    candidates_->candidates(segment.ray, 1.0, found);
    for (const int surface : found) ask(surface);
    free = std::min(free, margin_);
  } else {
    for (int i = 0; i < static_cast<int>(system_.surfaces().size()); ++i) ask(i);
  }
  return depth > 0.0 ? -depth : free;
}

double Visibility::clearance(const Segment& segment, int index) const {
  const auto& [name, shape, bounds, optics, region] = system_.surfaces()[index];
  const Ray& ray = segment.ray;
  const bool own = index == segment.own;
  if (!own && !region.may_meet(ray, margin_)) return margin_;
  thread_local RayParameters roots, still;
  roots.clear();
  still.clear();
  const double length = ray.direction.norm();
  const double near = kOwnShare + kOwnRoundings * geometry::kEpsilon *
                                      (ray.origin.cwiseAbs().maxCoeff() + system_.diameter()) / length;
  shape->crossings(ray, own ? -near : 0.0, 1.0, roots);
  if (own && !roots.empty()) {
    // The one crossing where the segment begins is not in its way.
    const auto first = std::min_element(roots.begin(), roots.end(), [](double a, double b) {
      return std::abs(a) < std::abs(b);
    });
    if (std::abs(*first) <= near) roots.erase(first);
  }
  shape->stationary(ray, 0.0, 1.0, still);

  double free = geometry::kInfinity, depth = 0.0, deepest = geometry::kInfinity;
  if (!still.empty()) deepest = 0.0;
  for (const double t : still) {
    const Point y = ray.at(t);
    const auto d = shape->derivatives(y);
    const double distance = std::abs(d.g) / d.gradient.norm();
    deepest = std::max(deepest, distance);
    // Only where |g| has a minimum does the segment come near without crossing.
    if (d.g * ray.direction.dot(d.hessian * ray.direction) > 0.0) {
      free = std::min(free, std::max(distance, margin_of(bounds, y)));
    }
  }
  for (const double t : roots) {
    if (t <= 0.0) continue;
    const double margin = margin_of(bounds, ray.at(t));
    if (margin > 0.0) {
      free = std::min(free, margin);
    } else if (t < segment.end) {
      const double out = std::min({-margin, deepest, (1.0 - t) * length});
      depth = std::max(depth, std::max(out, 1e-300));
    }
  }
  const auto near_end = [&](const Point& y) {
    Vec3 gradient;
    const double g = shape->value_gradient(y, gradient);
    free = std::min(free, std::max(std::abs(g) / gradient.norm(), margin_of(bounds, y)));
  };
  if (segment.end_moves) near_end(ray.at(1.0));
  if (!own) near_end(ray.origin);
  return depth > 0.0 ? -depth : free;
}

}  // namespace caustic::solver
