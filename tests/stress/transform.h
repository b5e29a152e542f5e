// The same scene, otherwise said: turned and shifted, mirrored, in another size, its surfaces in
// another order. Requests in, requests out; curves must be the same in the receiver's axes.
#pragma once

#include "tests/stress/oracle_scene.h"

namespace caustic::stress {

/// x ↦ R x + t of everything, t in the request's unit.
json moved(json request, const geometry::Mat3& rotation, const Vec3& translation);
/// x ↦ (−x₁, x₂, x₃).
json mirrored(json request);
/// Lengths times `factor`, the light so that irradiances stay.
json scaled(json request, double factor);
/// Surfaces in the opposite order.
json permuted(json request);

}  // namespace caustic::stress
