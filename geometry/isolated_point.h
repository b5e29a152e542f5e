// Where ∇g vanishes, a box too small to divide may hold a point that is no surface (S41).
#pragma once

#include "geometry/enclosure.h"

namespace caustic::geometry {

/// True if ∇g may vanish in the box and the Hessian is definite all over it: what the box holds is
/// an isolated point, or a sheet about it that is as small as the box.
inline bool holds_only_a_point(const SurfaceEnclosure& e) {
  const auto& [g, N, H] = e;
  if (!N[0].contains_zero() || !N[1].contains_zero() || !N[2].contains_zero()) return false;
  // Sylvester's minors: of one sign, or alternating.
  const Interval second = H[0] * H[3] - sqr(H[1]);
  const Interval third = H[0] * (H[3] * H[5] - sqr(H[4])) - H[1] * (H[1] * H[5] - H[4] * H[2]) +
                         H[2] * (H[1] * H[4] - H[3] * H[2]);
  return second.lo > 0.0 &&
         ((H[0].lo > 0.0 && third.lo > 0.0) || (H[0].hi < 0.0 && third.hi < 0.0));
}

}  // namespace caustic::geometry
