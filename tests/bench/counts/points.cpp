// At a point: a surface's derivatives, its crossings with a ray, the map with the irradiance.
#include <cmath>

#include "geometry/expression/field.h"
#include "geometry/sag.h"
#include "solver/forward_map.h"
#include "tests/bench/counts/subject.h"
#include "tests/support/random.h"
#include "tests/support/sampling.h"
#include "tests/support/scenes.h"

namespace caustic::bench {
namespace {

using namespace geometry;

constexpr int kPointsCounted = 256;

SurfacePtr by_expression(const char* text) {
  return make_expression(read_expression(text, 1.0), Box::around(Point::Zero(), 1.6), {}).surface;
}

SurfacePtr bumps() {
  HeightGrid grid{{-1, -1}, {1, 1}, 64, 64, {}};
  for (int j = 0; j < 64; ++j) {
    for (int i = 0; i < 64; ++i) {
      const double x = 2.0 * i / 63 - 1.0, y = 2.0 * j / 63 - 1.0;
      grid.values.push_back(0.3 * (x * x + y * y) + 0.01 * std::sin(9.0 * x) * std::cos(7.0 * y));
    }
  }
  return make_sag(Point::Zero(), Mat3::Identity(), grid);
}

struct Specimen {
  const char* name;
  SurfacePtr (*make)();
};
const Specimen kSpecimens[] = {
    {"plane", [] { return make_plane(Point(0, 0, 0.1), Direction(0.1, -0.2, 1.0).normalized()); }},
    {"sphere", [] { return make_sphere(Point::Zero(), 1.0); }},
    {"ellipsoid",
     [] {
       return make_ellipsoid(Point::Zero(), {1, 1.4, 0.8}, Mat3::Identity());
     }},
    {"torus",
     [] {
       return make_torus(Point::Zero(), {0, 0, 1}, 1.0, 0.4);
     }},
    {"asphere",
     [] {
       return make_conic({0, 0, 0}, {0, 0, 1}, 2.0, -0.8, {0.01, -0.002});
     }},
    {"revolution",
     [] {
       return make_revolution({0, 0, -1}, {0, 0, 1}, 2.0, {0.47, 3.90, -9.78, 5.80}).surface;
     }},
    {"heights", bumps},
    {"expression_sphere", [] { return by_expression("x^2+y^2+z^2-1"); }},
    {"expression_cuboid", [] { return by_expression("x^4+y^4+z^4-x^2-y^2-z^2"); }},
    {"expression_water", [] { return by_expression("z-0.1*sin(2*pi*x)"); }},
};

std::vector<Point> on(const Surface& surface) {
  test::Random random(1);
  return test::sample_surface(surface, test::extent_about(Point::Zero(), 1.2), kPointsCounted,
                              random);
}

// All that tracing asks a surface for at a point.
Work derivatives(const SurfacePtr& surface) {
  const Direction u = Direction(1, 2, 2) / 3.0, v = Direction(2, 1, -2) / 3.0;
  return {[=, points = on(*surface)] {
            for (const Point& x : points) {
              keep(surface->derivatives(x));
              keep(surface->third_derivatives(x, u, v));
            }
          },
          kPointsCounted};
}

Work crossings(const SurfacePtr& surface) {
  std::vector<Ray> rays;
  for (const Point& x : on(*surface)) {
    rays.push_back({x + 5.0 * Vec3(0.3, 0.2, 1.0), -6.0 * Vec3(0.3, 0.2, 1.0)});
  }
  return {[=] {
            RayParameters found;
            for (const Ray& ray : rays) {
              found.clear();
              surface->crossings(ray, 0.0, 1.0, found);
              keep(found);
            }
          },
          kPointsCounted};
}

Work evaluation(solver::OpticalSystem made, const solver::Hops& hops, std::vector<Point> points) {
  struct Mapped {  // the map refers to the system
    solver::OpticalSystem system;
    solver::ForwardMap map;
    Mapped(solver::OpticalSystem s, const solver::Hops& hops)
        : system(std::move(s)), map(system, hops) {}
  };
  const auto mapped = std::make_shared<const Mapped>(std::move(made), hops);
  for (Point& x : points) x = mapped->map.project(x);
  return {[=] {
            for (const Point& x : points) keep(mapped->map.evaluate(x));
          },
          points.size()};
}

Work one_bounce(const SurfacePtr& surface) {
  return evaluation(test::one_mirror(solver::PointLight{{0.6, 0.5, 3.0}, 1.0}, surface,
                                     test::floor_at({0, 0, 4}, 6.0, 6.0)),
                    {{0, 1}}, on(*surface));
}

// Off a ball and a dish about it.
Work two_bounces() {
  auto system = solver::OpticalSystem::build(solver::PointLight{{0.6, 0.5, 3.0}, 1.0},
                                             {test::mirror(make_sphere(Point::Zero(), 1.0)),
                                              test::mirror(make_sphere(Point::Zero(), 6.0))},
                                             test::floor_at({0, 0, -1.5}, 8.0, 8.0));
  test::Random random(1);
  std::vector<Point> points;
  for (int i = 0; i < kPointsCounted; ++i)
    points.push_back(Point(0.3, 0.2, 1.0) + random.in_cube(0.3));
  return evaluation(std::move(system), {{0, 1}, {1, -1}}, std::move(points));
}

}  // namespace

void add_points(Subjects& subjects) {
  for (const auto& [name, make] : kSpecimens) {
    const std::string of = std::string("/") + name;
    subjects.push_back({"derivatives" + of, "points", [=] { return derivatives(make()); }});
    subjects.push_back({"crossings" + of, "rays", [=] { return crossings(make()); }});
    subjects.push_back({"evaluation" + of, "points", [=] { return one_bounce(make()); }});
  }
  subjects.push_back({"evaluation/two_bounces", "points", two_bounces});
}

}  // namespace caustic::bench
