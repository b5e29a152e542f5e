// Vectors in an answer.
#pragma once

#include <nlohmann/json.hpp>

#include "geometry/linear.h"

namespace caustic::service {

/// [x, y, z], each times `scale`: one over the length unit in metres for points.
inline nlohmann::ordered_json vector_json(const geometry::Vec3& v, double scale) {
  return {v.x() * scale, v.y() * scale, v.z() * scale};
}

}  // namespace caustic::service
