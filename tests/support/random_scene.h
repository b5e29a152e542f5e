// Scenes drawn at random, skewed to trouble: all shapes, apertures, several surfaces in each
// other's way.
#pragma once

#include <sstream>

#include "tests/support/random.h"
#include "tests/support/scenes.h"
#include "tests/support/shape_zoo.h"

namespace caustic::test {

struct RandomScene {
  solver::OpticalSystem system;
  std::string description;
};

inline std::vector<geometry::Bound> random_aperture(Random& random, const geometry::Point& about) {
  switch (random.index(5)) {
    case 0:
      return {};
    case 1: {
      const geometry::Vec3 half(random.uniform(0.3, 2), random.uniform(0.3, 2),
                                random.uniform(0.3, 2));
      return geometry::box_aperture(about - half, about + half);
    }
    case 2:
      return {geometry::cylinder_aperture(about, random.direction(), random.uniform(0.4, 2))};
    case 3:
      return {geometry::half_space_aperture(about + random.in_cube(0.3), random.direction())};
    default:
      return {geometry::half_space_aperture(about + random.in_cube(0.3), random.direction()),
              geometry::cylinder_aperture(about, random.direction(), random.uniform(0.4, 2))};
  }
}

inline RandomScene random_scene(std::uint64_t seed) {
  Random random(seed);
  std::ostringstream text;
  text << "seed " << seed << ":";
  std::vector<solver::SystemSurface> surfaces;
  const int count = random.index(3) == 0 ? 1 + random.index(3) : 1;
  for (int i = 0; i < count; ++i) {
    const auto& zoo = shape_zoo();
    ShapeSpec spec = zoo[random.index(static_cast<int>(zoo.size()))];
    if (i > 0) spec.pose.translation += 2.5 * random.direction();
    auto bounds = random_aperture(random, spec.pose.translation);
    text << " " << spec.name << (bounds.empty() ? "" : " cut");
    const bool absorbs = i > 0 && random.index(2) == 0;
    surfaces.push_back(absorbs ? absorber(build(spec), std::move(bounds))
                               : mirror(build(spec), std::move(bounds), random.uniform(0.3, 1.0)));
    surfaces.back().name += std::to_string(i);
  }
  solver::Light light = solver::CollimatedLight{random.direction(), random.log_uniform(0.1, 100.0)};
  if (random.index(3) > 0) {
    light = solver::PointLight{random.in_cube(random.index(2) == 0 ? 1.5 : 4.0),
                               random.log_uniform(0.1, 100.0)};
    text << ", point light";
  }
  const double width = random.uniform(1.0, 8.0);
  const auto receiver =
      geometry::ReceiverFrame::make(random.in_cube(4.0), random.direction(), random.direction(),
                                    {width, random.uniform(0.5, 1.0) * width});
  return {solver::OpticalSystem::build(light, std::move(surfaces), receiver), text.str()};
}

}  // namespace caustic::test
