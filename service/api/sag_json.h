// The shape `sag`: heights over a plane, by a polynomial, by Zernike's or by samples on a grid.
#pragma once

#include "geometry/surface.h"
#include "service/api/json_reader.h"

namespace caustic::service {

/// Null, with faults noted, if the description is faulty. `metres` is the length unit in metres.
geometry::SurfacePtr read_sag(ObjectReader& shape, double metres, const geometry::Pose& pose);

}  // namespace caustic::service
