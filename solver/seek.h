// Rays of a cell all of which miss a surface: may those between them meet it? What a cell is
// divided for until something small is found, wherever cells are divided.
#pragma once

#include <span>

#include "geometry/linear.h"

namespace caustic::solver {

/// A ray that meets nothing of the next surface of its family.
struct NearMiss {
  int hop = -1;  ///< of the surface that it misses; −1 if it ends otherwise
  geometry::Point o = geometry::Point::Zero();  ///< its last hit
  geometry::Vec3 w = geometry::Vec3::Zero();    ///< its direction, of any length
};

enum class Between {
  nothing,  ///< all rays of the cell pass by the surface
  perhaps,  ///< it may lie between them
  dense,    ///< they lie closer than the surface is large, so they would meet what they pass
  mixed     ///< they do not all miss the same surface
};
/// Judged by how the rays pass by the middle of `region`, in which the surface exists: between them
/// that changes no more than among them (S43).
Between between(std::span<const NearMiss> rays, const NearMiss& middle,
                const geometry::Box& region);

}  // namespace caustic::solver
