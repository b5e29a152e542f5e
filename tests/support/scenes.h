// Systems of one or more mirrors in a line or two, and the public cases.
#pragma once

#include <utility>
#include <vector>

#include "solver/contours.h"
#include "solver/optical_system.h"

namespace caustic::test {

inline solver::SystemSurface mirror(geometry::SurfacePtr shape,
                                    std::vector<geometry::Bound> bounds = {},
                                    double reflectance = 1.0) {
  solver::SystemSurface surface{
      .name = "mirror", .shape = std::move(shape), .bounds = std::move(bounds), .optics = {}};
  surface.optics.reflectance = reflectance;
  return surface;
}

inline solver::SystemSurface absorber(geometry::SurfacePtr shape,
                                      std::vector<geometry::Bound> bounds = {}) {
  solver::SystemSurface surface = mirror(std::move(shape), std::move(bounds));
  surface.name = "absorber";
  surface.optics.kind = solver::Optics::Kind::absorb;
  return surface;
}

inline solver::OpticalSystem one_mirror(solver::Light light, geometry::SurfacePtr shape,
                                        const geometry::ReceiverFrame& receiver,
                                        std::vector<geometry::Bound> bounds = {},
                                        double reflectance = 1.0) {
  return solver::OpticalSystem::build(
      std::move(light), {mirror(std::move(shape), std::move(bounds), reflectance)}, receiver);
}

/// Receiver across z with axes x and y.
inline geometry::ReceiverFrame floor_at(const geometry::Point& origin, double width, double depth) {
  return geometry::ReceiverFrame::make(origin, {1, 0, 0}, {0, 1, 0}, {width, depth});
}

}  // namespace caustic::test
