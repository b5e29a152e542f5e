// The `shape` and the `aperture` of a surface, converted to SI with the pose applied.
#pragma once

#include <vector>

#include "geometry/surface.h"
#include "service/api/json_reader.h"

namespace caustic::service {

constexpr std::size_t kMaxApertures = 1000;

/// Null, with faults noted, if the description is faulty. `metres` is the length unit in metres.
geometry::SurfacePtr read_shape(const JsonPlace& place, double metres, const geometry::Pose& pose,
                                Faults& faults);

/// Appends the bounds of one aperture. Apertures are in world coordinates: no pose.
void read_aperture(const JsonPlace& place, double metres, std::vector<geometry::Bound>& bounds,
                   Faults& faults);

}  // namespace caustic::service
