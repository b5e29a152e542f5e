#include "tests/bench/methods/closed_forms.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/strips.h"

namespace caustic::bench {

using geometry::kPi;
using geometry::Vec2;

namespace {

// Of the ray that meets the ball at the polar angle θ: where it comes to the ceiling, and E by the
// flux of a ring, I sin ω dω = E r dr with ω the angle at the lamp.
struct RingOfLight {
  long double radius, irradiance;
};
RingOfLight ring_of_light(long double theta) {
  using std::cos, std::sin, std::tan;
  const long double s = sin(theta), c = cos(theta), d2 = 17 - 8 * c;  // |x − lamp|²
  const long double omega = std::atan2(s, 4 - c), omega_ = (4 * c - 1) / d2;
  const long double beta = 2 * theta + omega, beta_ = 2 + omega_;  // of the ray, against the axis
  const long double radius = s + (6 - c) * tan(beta);
  const long double slope = c + s * tan(beta) + (6 - c) * beta_ / (cos(beta) * cos(beta));
  return {radius, sin(omega) * omega_ / (radius * slope)};
}

constexpr double kHalfArc = kPi / 3.0;

Vec2 way(double phi) { return {std::cos(2.0 * phi), std::sin(2.0 * phi)}; }
Vec2 arrival(double phi, double t) { return Vec2(std::cos(phi), std::sin(phi)) - t * way(phi); }

// Distance from a curve, by samples and golden sections between the neighbours of the nearest.
template <class Curve>
double nearest(const Curve& curve, double begin, double end, const Vec2& q) {
  constexpr int kPlaces = 4000;
  const auto distance = [&](double p) { return (curve(p) - q).norm(); };
  const double step = (end - begin) / kPlaces;
  int best = 0;
  for (int i = 1; i <= kPlaces; ++i)
    if (distance(begin + i * step) < distance(begin + best * step)) best = i;
  double a = begin + std::max(best - 1, 0) * step, b = begin + std::min(best + 1, kPlaces) * step;
  for (int i = 0; i < 100; ++i) {
    const double left = a + 0.382 * (b - a), right = b - 0.382 * (b - a);
    (distance(left) < distance(right) ? b : a) = distance(left) < distance(right) ? right : left;
  }
  return std::min(distance(a), distance(b));
}

}  // namespace

double circle_of_a_ball(double level) {
  long double bright = 1e-3L, dark = 1.1L;
  for (int i = 0; i < 100; ++i) {
    const long double middle = (bright + dark) / 2;
    (ring_of_light(middle).irradiance > level ? bright : dark) = middle;
  }
  return static_cast<double>(ring_of_light(bright).radius);
}

double NephroidRing::irradiance(const Vec2& q) const {
  const auto f = [&](double phi) {
    return q.x() * std::sin(2.0 * phi) - q.y() * std::cos(2.0 * phi) - std::sin(phi);
  };
  const auto slope = [&](double phi) {
    return 2.0 * q.x() * std::cos(2.0 * phi) + 2.0 * q.y() * std::sin(2.0 * phi) - std::cos(phi);
  };
  constexpr int kPieces = 2000;
  std::vector<double> turns{-kHalfArc};  // between them f is monotone
  for (int i = 0; i < kPieces; ++i) {
    const double a = kHalfArc * (2.0 * i / kPieces - 1.0),
                 b = kHalfArc * (2.0 * (i + 1) / kPieces - 1.0);
    if ((slope(a) > 0.0) != (slope(b) > 0.0)) turns.push_back(test::root_of(slope, a, b));
  }
  turns.push_back(kHalfArc);
  double sum = 0.0;
  for (std::size_t i = 1; i < turns.size(); ++i) {
    if ((f(turns[i - 1]) > 0.0) == (f(turns[i]) > 0.0)) continue;
    const double phi = test::root_of(f, turns[i - 1], turns[i]);
    const double t = way(phi).dot(arrival(phi, 0.0) - q);
    if (t >= 0.0 && t <= 1.0)
      sum += std::cos(phi) / (std::sqrt(2.0) * std::abs(std::cos(phi) - 2.0 * t));
  }
  return sum;
}

double NephroidRing::distance_from_caustic(const Vec2& q) const {
  return nearest([](double phi) { return arrival(phi, 0.5 * std::cos(phi)); }, -kHalfArc, kHalfArc,
                 q);
}

double NephroidRing::distance_from_edges(const Vec2& q) const {
  double least = geometry::kInfinity;
  for (const double end : {0.0, 1.0})
    least = std::min(
        least, nearest([=](double phi) { return arrival(phi, end); }, -kHalfArc, kHalfArc, q));
  for (const double side : {-kHalfArc, kHalfArc})
    least = std::min(least, nearest([=](double t) { return arrival(side, t); }, 0.0, 1.0, q));
  return least;
}

}  // namespace caustic::bench
