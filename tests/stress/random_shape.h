// A random shape of a request, of size one about the origin of its own frame, with the places that
// are trouble.
#pragma once

#include <vector>

#include "tests/stress/oracle_scene.h"
#include "tests/support/random.h"

namespace caustic::stress {

struct RandomShape {
  json shape{};
  std::vector<Point> foci{};  ///< or centres: where light from the one goes to the other
  Vec3 axis = Vec3::UnitZ();  ///< of symmetry, through `middle`
  Point middle = Point::Zero();
  double radius = 1.0;  ///< what matters of it is so near to `middle`
  bool bounded = true;
};

RandomShape random_shape(test::Random& random);
/// How many kinds there are, and one of each.
int shape_kinds();
RandomShape random_shape(int kind, test::Random& random);

}  // namespace caustic::stress
