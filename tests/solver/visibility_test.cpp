// What a look promises: as far as its room reaches nothing changes, whoever is asked.
#include "solver/visibility.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace caustic::solver {
namespace {

using namespace geometry;

// A field of small balls about a larger one, in a plane or in space.
OpticalSystem field_of_balls(int count, double height, test::Random& random) {
  std::vector<SystemSurface> surfaces{test::mirror(make_sphere(Point::Zero(), 0.3))};
  while (static_cast<int>(surfaces.size()) <= count) {
    Point place = random.in_cube(2.0);
    place.z() *= height;
    if (place.norm() > 0.5) surfaces.push_back(test::absorber(make_sphere(place, 0.06)));
  }
  return OpticalSystem::build(PointLight{{0.5, 0.2, 3.0}, 1.0}, std::move(surfaces),
                              test::floor_at({0, 0, 4}, 8.0, 8.0));
}

bool crosses(const OpticalSystem& system, const Point& from, const Point& to) {
  for (std::size_t i = 1; i < system.surfaces().size(); ++i) {
    RayParameters roots;
    system.surfaces()[i].shape->crossings({from, to - from}, 0.0, 1.0, roots);
    if (!roots.empty()) return true;
  }
  return false;
}

// The path of light that arrives at p by way of x; that it is not reflected so does not matter
// here.
LightPath path_by(const ForwardMap& map, const Point& x, const Point& p) {
  return {map, x, nullptr, p};
}

TEST(Visibility, NothingChangesWithinTheRoom) {
  test::Random random(5);
  int moved = 0, hidden = 0, far = 0;
  for (const double height : {0.05, 1.0}) {
    const OpticalSystem system = field_of_balls(60, height, random);
    const ForwardMap map(system, 0, 1);
    std::vector<Box> boxes;
    for (const auto& surface : system.surfaces()) boxes.push_back(surface.region);
    const double margin = 0.02;
    const EmbreeScene candidates(boxes, margin);
    const Visibility by_each(system, nullptr, margin), by_embree(system, &candidates, margin);
    const Point light = std::get<PointLight>(system.light()).position;
    for (int i = 0; i < 800; ++i) {
      Direction n = random.direction();
      n.z() = std::abs(n.z());
      const Point x = 0.3 * n, p(random.uniform(-4, 4), random.uniform(-4, 4), 4.0);
      if (n.dot(p - x) <= 0.0 || n.dot(light - x) <= 0.0) continue;
      const LightPath path = path_by(map, x, p);
      const Sight sight = by_embree.look(map.hops(), path);
      const bool blocked = crosses(system, x, light) || crosses(system, x, p);
      EXPECT_EQ(sight.hidden, blocked);
      EXPECT_EQ(by_each.hidden(map.hops(), path), blocked);
      hidden += blocked;
      for (const double reach : {0.01, 0.1, 1.0}) {
        const Point y = 0.3 * (n + 0.3 * reach * random.direction()).normalized();
        const Point q = p + Point(random.uniform(-reach, reach), random.uniform(-reach, reach), 0);
        if (y.dot(q - y) <= 0.0 || y.dot(light - y) <= 0.0) continue;
        if (sight.used(path, path_by(map, y, q)) >= kUsableRoom) continue;
        ++moved;
        far += (q - p).norm() > 3.0 * margin;
        EXPECT_EQ(crosses(system, y, light) || crosses(system, y, q), blocked);
      }
    }
  }
  EXPECT_GT(hidden, 50);
  EXPECT_GT(moved, 200);
  EXPECT_GT(far, 20);  // where it leaves the balls soon, the way to the receiver may swing far
}

}  // namespace
}  // namespace caustic::solver
