// The functions whose zeros are the edges of what surfaces hide: against distances in closed form,
// and their slopes against central differences of those.
#include "solver/hidden_edge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>

#include "tests/support/scenes.h"

namespace caustic::solver {
namespace {

using geometry::box_aperture;
using geometry::make_plane;
using geometry::make_sphere;
using test::floor_at;

const Point kSource(0.1, 0.05, 1.5);

// A curved mirror, and something in the way.
OpticalSystem bowl_and(Light light, SystemSurface blocker) {
  return OpticalSystem::build(
      light,
      {test::mirror(make_sphere({0, 0, 4}, 4.0), box_aperture({-1, -1, -1}, {1, 1, 1})), blocker},
      floor_at({0, 0, 2}, 6, 6));
}

// The path from x by hand: where light comes from, and where it goes on the plane z = 2.
struct Bounce {
  Point x, from, to;
};
Bounce bounce_at(const Light& light, double u, double v) {
  const Point x(u, v, 4.0 - std::sqrt(16.0 - u * u - v * v));
  const auto* lamp = std::get_if<PointLight>(&light);
  const Point from =
      lamp ? lamp->position : Point(x - 5.0 * std::get<CollimatedLight>(light).direction);
  const Vec3 n = (Point(0, 0, 4) - x).normalized(), d = (x - from).normalized();
  const Vec3 out = d - 2.0 * d.dot(n) * n;
  return {x, from, x + (2.0 - x.z()) / out.z() * out};
}

// `oracle` up to the sign of h; segment 0 from the light, 1 to the receiver; y a place near to
// which it passes. The mirror's slopes in x and y are those of a walk over it.
void expect_function(const Light& light, const SystemSurface& blocker, Hiding hiding, double u,
                     double v, const Point& y, const std::function<double(const Bounce&)>& oracle) {
  const OpticalSystem system = bowl_and(light, blocker);
  if (hiding.kind == Hiding::Kind::rim) hiding.bound = &system.surfaces()[1].bounds[0];
  const ForwardMap map(system, 0, -1);
  const auto field_at = [&](double a, double b) { return map.evaluate(bounce_at(light, a, b).x); };
  const FieldPoint f = field_at(u, v);
  ASSERT_TRUE(f.arrives());
  const HiddenEdge edge(map, hiding, f, y, 1e-3);
  const auto expected = [&](double a, double b) { return oracle(bounce_at(light, a, b)); };
  const double sign = std::copysign(1.0, edge.value(f) * expected(u, v));
  EXPECT_NEAR(edge.value(f), sign * expected(u, v), 1e-13);
  EXPECT_NEAR(edge.value(field_at(u + 0.01, v - 0.02)), sign * expected(u + 0.01, v - 0.02), 1e-13);
  const double step = 1e-5, slope = -4.0 + f.x.z();  // z_x = x/(4 − z)
  const Vec3 along_u(1, 0, -f.x.x() / slope), along_v(0, 1, -f.x.y() / slope);
  const auto difference = [&](double a, double b) {
    return sign * (expected(u + a, v + b) - expected(u - a, v - b)) / (2.0 * step);
  };
  EXPECT_NEAR(edge.gradient(f).dot(along_u), difference(step, 0), 1e-8);
  EXPECT_NEAR(edge.gradient(f).dot(along_v), difference(0, step), 1e-8);
}

double square_to_line(const Point& c, const Point& a, const Point& b) {
  return (c - a).cross(b - a).squaredNorm() / (b - a).squaredNorm();
}

const Light kLights[] = {PointLight{kSource, 1.0},
                         CollimatedLight{Vec3(0.2, 0.1, -1).normalized(), 1.0}};

// g of a sphere is (|y − c|² − r²)/(2r), which is least where the segment passes the centre.
TEST(HiddenEdge, TouchesABallAtItsDistanceFromTheSegment) {
  const Point center(0.3, 0.1, 0.9);
  const double radius = 0.2;
  const auto ball = test::absorber(make_sphere(center, radius));
  for (const Light& light : kLights) {
    for (const int segment : {0, 1}) {
      expect_function(light, ball, {Hiding::Kind::touch, segment, 1}, 0.25, 0.1, center,
                      [&](const Bounce& path) {
                        const Point &a = segment == 0 ? path.from : path.x,
                                    &b = segment == 0 ? path.x : path.to;
                        return (square_to_line(center, a, b) - radius * radius) / (2.0 * radius);
                      });
    }
  }
}

// From a single place that is known, where along the segment it is told by its derivative: farther
// than it is let move without.
TEST(HiddenEdge, FollowsAFastTouch) {
  const Point center(8.0, 0.1, 0.9);
  const double radius = 0.2;
  const auto ball = test::absorber(make_sphere(center, radius));
  for (const auto& [light, u] : {std::pair(kLights[0], 0.28), std::pair(kLights[1], 0.17)}) {
    const auto foot = [&](const Bounce& path) {
      const Vec3 D = path.to - path.x;
      return (center - path.x).dot(D) / D.squaredNorm();
    };
    const Bounce from = bounce_at(light, 0.1, 0.1), to = bounce_at(light, u, 0.1);
    ASSERT_GT(std::abs(foot(to) - foot(from)), 0.1);
    const OpticalSystem system = bowl_and(light, ball);
    const ForwardMap map(system, 0, -1);
    const HiddenEdge edge(map, {Hiding::Kind::touch, 1, 1}, map.evaluate(from.x),
                          from.x + foot(from) * (from.to - from.x), 1e3);
    const FieldPoint f = map.evaluate(to.x);
    const double square = square_to_line(center, to.x, to.to);
    EXPECT_NEAR(edge.value(f), (square - radius * radius) / (2.0 * radius), 1e-12);
    EXPECT_LT((edge.place(f) - to.x - foot(to) * (to.to - to.x)).norm(), 1e-12);
  }
}

// The first bound of a plate's box is its side x ≤ 0.6: a straight rim.
TEST(HiddenEdge, PassesARimAtTheDistanceOfTwoLines) {
  const Vec3 normal = Vec3(0.3, 0.1, 1).normalized();
  auto plate = test::absorber(make_plane({0.4, 0.1, 0.8}, normal));
  plate.bounds = box_aperture({-1, -1, 0}, {0.6, 1, 2});
  const Vec3 along = normal.cross(Vec3(1, 0, 0)).normalized();
  const Point on(0.6, 0.1, 0.8 - 0.3 * 0.2);
  for (const Light& light : kLights) {
    for (const int segment : {0, 1}) {
      expect_function(light, plate, {Hiding::Kind::rim, segment, 1}, 0.4, 0.1, on,
                      [&](const Bounce& path) {
                        const Point& a = segment == 0 ? path.from : path.x;
                        const Vec3 D = (segment == 0 ? path.x : path.to) - a;
                        return (on - a).dot(along.cross(D).normalized());
                      });
    }
  }
}

// A wall through the mirror hides what lies behind it; and one that the receiver runs through.
TEST(HiddenEdge, BeginsAndEndsOnAWall) {
  const Vec3 normal = Vec3(1, 0.2, 0.3).normalized();
  const Point on(0.3, 0.1, 0.0);
  const auto wall = test::absorber(make_plane(on, normal));
  for (const Light& light : kLights) {
    for (const int point : {1, 2}) {
      expect_function(
          light, wall, {Hiding::Kind::point, 1, 1, nullptr, point}, 0.25, 0.1, on,
          [&](const Bounce& path) { return normal.dot((point == 1 ? path.x : path.to) - on); });
    }
  }
}

}  // namespace
}  // namespace caustic::solver
