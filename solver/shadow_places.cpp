#include "solver/shadow_places.h"

namespace caustic::solver {

std::vector<std::vector<geometry::Point>> places_behind_surfaces(const OpticalSystem& system) {
  const geometry::ReceiverFrame& receiver = system.receiver();
  const auto* lamp = std::get_if<PointLight>(&system.light());
  std::vector<std::vector<geometry::Point>> all;
  for (const SystemSurface& surface : system.surfaces()) {
    all.emplace_back();
    const geometry::Vec3 size = surface.region.max - surface.region.min;
    const auto add = [&](double i, double j, double k) {
      const geometry::Point y =
          surface.region.center() + 0.25 * size.cwiseProduct(geometry::Vec3(i, j, k));
      const geometry::Vec3 d = lamp ? geometry::Vec3(y - lamp->position)
                                    : std::get<CollimatedLight>(system.light()).direction;
      const double t = -receiver.m.dot(y - receiver.origin) / receiver.m.dot(d);
      const geometry::Vec3 arm = y + t * d - receiver.origin;
      const geometry::Vec2 q(receiver.u.dot(arm), receiver.v.dot(arm));
      if (t > 0.0 && receiver.contains(q)) all.back().push_back(receiver.point(q));
    };
    add(0, 0, 0);
    for (const int i : {-1, 0, 1}) {
      for (const int j : {-1, 0, 1}) {
        for (const int k : {-1, 0, 1}) {
          if (i != 0 || j != 0 || k != 0) add(i, j, k);
        }
      }
    }
  }
  return all;
}

}  // namespace caustic::solver
