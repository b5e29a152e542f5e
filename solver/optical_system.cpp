#include "solver/optical_system.h"

namespace caustic::solver {

namespace {

// An unbounded surface exists inside a ball this many diameters of the rest of the scene (api.md).
constexpr double kClipDiameters = 1e3;

// A bound of an aperture that admits all that the others leave is none: exploration and tracing
// need not ask it, and no curve ends there. The shape's own are why its box is no larger: they
// stay.
void drop_idle_bounds(SystemSurface& surface) {
  auto& bounds = surface.bounds;
  for (std::size_t i = 0; i < bounds.size();) {
    const geometry::Bound bound = bounds[i];
    if (bound.origin == geometry::Bound::Origin::shape) {
      ++i;
      continue;
    }
    bounds.erase(bounds.begin() + static_cast<std::ptrdiff_t>(i));
    const auto rest = surface.shape->bounds().intersected(geometry::box_of(bounds));
    if (rest.bounded() && !rest.empty() && bound.largest_in(rest) <= 0.0) continue;
    bounds.insert(bounds.begin() + static_cast<std::ptrdiff_t>(i++), bound);
  }
}

void include(geometry::Box& box, const geometry::Point& x) {
  box = {box.min.cwiseMin(x), box.max.cwiseMax(x)};
}

}  // namespace

OpticalSystem OpticalSystem::build(Light light, std::vector<SystemSurface> surfaces,
                                   geometry::ReceiverFrame receiver) {
  OpticalSystem system;
  geometry::Box scene{geometry::Point::Constant(geometry::kInfinity),
                      geometry::Point::Constant(-geometry::kInfinity)};
  for (const double i : {-1.0, 1.0}) {
    for (const double j : {-1.0, 1.0}) {
      include(scene, receiver.point({i * receiver.half.x(), j * receiver.half.y()}));
    }
  }
  system.receiver_plane_ = {"receiver",
                            geometry::make_plane(receiver.origin, receiver.m),
                            {},
                            {Optics::Kind::absorb},
                            scene};
  if (const auto* point = std::get_if<PointLight>(&light)) include(scene, point->position);
  for (SystemSurface& surface : surfaces) {
    for (const auto& bound : surface.shape->own_bounds()) surface.bounds.push_back(bound);
    drop_idle_bounds(surface);
    surface.region = surface.shape->bounds().intersected(geometry::box_of(surface.bounds));
    if (surface.region.bounded() && !surface.region.empty()) {
      include(scene, surface.region.min);
      include(scene, surface.region.max);
    }
  }

  system.center_ = scene.center();
  system.diameter_ = scene.diagonal();
  const double clip = 0.5 * kClipDiameters * system.diameter_;
  for (SystemSurface& surface : surfaces) {
    if (surface.region.bounded()) continue;
    surface.bounds.push_back(geometry::ball(system.center_, clip, geometry::Bound::Origin::clip));
    surface.region = surface.region.intersected(geometry::Box::around(system.center_, clip));
  }
  for (SystemSurface& surface : surfaces)
    surface.region = geometry::without_excluded_sides(surface.region, surface.bounds);
  system.extent_ = {geometry::Point::Constant(geometry::kInfinity),
                    geometry::Point::Constant(-geometry::kInfinity)};
  for (const SystemSurface& surface : surfaces) {
    if (surface.region.empty()) continue;
    include(system.extent_, surface.region.min);
    include(system.extent_, surface.region.max);
  }
  system.light_ = std::move(light);
  system.surfaces_ = std::move(surfaces);
  system.receiver_ = receiver;
  return system;
}

}  // namespace caustic::solver
