#include "geometry/opening.h"

#include <algorithm>
#include <cmath>

namespace caustic::geometry {

namespace {

constexpr int kApproaches = 40;  // projections until inside
constexpr int kClimbs = 40;      // steps of a climb, halved where they do not help
constexpr int kNewtonSteps = 5;  // back to the surface, until one is this share of its place
constexpr double kOnSurfaceShare = 1e-9;
// A climb is at its top when its steps are this share of the margin found.
constexpr double kTopShare = 0.1;
// From the top so many directions are looked along, so many times as far as is known to exist.
constexpr int kDirections = 8;
constexpr double kFarther = 4.0;
// Only if the margin is less than this share of enough: else it is near enough.
constexpr double kSliverShare = 1e-2;

double largest(const std::vector<Bound>& bounds, const Point& x) {
  double h = -kInfinity;
  for (const Bound& b : bounds) h = std::max(h, b.value(x));
  return h;
}

// Direction that leads away from all bounds that are within `reach` of the worst one.
Vec3 away(const std::vector<Bound>& bounds, const Point& x, double worst, double reach) {
  Vec3 sum = Vec3::Zero();
  for (const Bound& b : bounds) {
    if (b.value(x) >= worst - reach) sum -= b.gradient(x).normalized();
  }
  const double length = sum.norm();
  return length > 1e-6 ? Vec3(sum / length) : Vec3::Zero();
}

// Newton's method back to the surface; near it two steps are enough. Off it margins are not those
// of what exists.
Point towards_surface(const Surface& surface, Point x) {
  Vec3 gradient;
  for (int i = 0; i < kNewtonSteps; ++i) {
    const double g = surface.value_gradient(x, gradient);
    const Vec3 step = gradient * (g / gradient.squaredNorm());
    if (!step.allFinite()) break;
    x -= step;
    if (step.squaredNorm() <= kOnSurfaceShare * kOnSurfaceShare * x.squaredNorm()) break;
  }
  return x;
}

// Projections onto the worst bound and back to the surface, until x exists.
Point approach(const Surface& surface, const std::vector<Bound>& bounds, Point x) {
  for (int i = 0; i < kApproaches; ++i) {
    const auto worst = std::max_element(bounds.begin(), bounds.end(),
                                        [&](auto& a, auto& b) { return a.value(x) < b.value(x); });
    const double h = worst->value(x);
    if (h <= 0.0) break;
    const Vec3 slope = worst->gradient(x);
    x = towards_surface(surface, x - slope * (h / slope.squaredNorm()));
  }
  return x;
}

// How far the surface exists about x, about which it does so for `room`. A margin is no more than
// that, and much less where the surface all but touches a bound.
double room_about(const Surface& surface, const std::vector<Bound>& bounds, const Point& x,
                  double room, double enough) {
  Vec3 gradient;
  surface.value_gradient(x, gradient);
  const Frame along(gradient.normalized());
  const auto exists = [&](int k) {
    const double angle = 2.0 * kPi * k / kDirections;
    const Vec3 direction = std::cos(angle) * along.e1 + std::sin(angle) * along.e2;
    return largest(bounds, towards_surface(surface, x + kFarther * room * direction)) <= 0.0;
  };
  while (room > 0.0 && room < enough) {
    for (int k = 0; k < kDirections; ++k) {
      if (!exists(k)) return room;
    }
    room *= kFarther;
  }
  return std::min(room, enough);
}

}  // namespace

double opening_radius(const Surface& surface, const std::vector<Bound>& bounds,
                      const std::vector<Point>& starts, double enough) {
  if (bounds.empty()) return enough;
  double best = -kInfinity;
  Point top = Point::Zero();
  for (const Point& start : starts) {
    Point x = approach(surface, bounds, start);
    double h = largest(bounds, x), step = enough;
    for (int i = 0; i < kClimbs && -h < enough && step > kTopShare * -h; ++i) {
      const Point next = towards_surface(surface, x + step * away(bounds, x, h, step));
      const double h_next = largest(bounds, next);
      if (h_next < h) {
        x = next;
        h = h_next;
      } else {
        step *= 0.5;
      }
    }
    if (!(-h > best)) continue;
    best = -h;
    top = x;
    if (best >= enough) return enough;
  }
  return best < kSliverShare * enough ? room_about(surface, bounds, top, best, enough) : best;
}

}  // namespace caustic::geometry
