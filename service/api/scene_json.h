// The `scene` of a request: light, surfaces, receiver, converted to SI.
#pragma once

#include <string>
#include <vector>

#include "geometry/receiver_frame.h"
#include "service/api/json_reader.h"
#include "service/api/units.h"
#include "solver/light.h"
#include "solver/optical_system.h"

namespace caustic::service {

constexpr std::size_t kMaxSurfaces = 10'000;

struct Scene {
  Units units;
  solver::Light light;
  std::vector<solver::SystemSurface> surfaces;
  geometry::ReceiverFrame receiver;
};

/// Notes every fault; the scene means something only if there is none. A surface whose description
/// is faulty has no shape, but it has its name.
Scene read_scene(const JsonPlace& place, Faults& faults);

}  // namespace caustic::service
