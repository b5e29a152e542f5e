#include "geometry/narrowed.h"

namespace caustic::geometry {

NarrowedEnclosure narrowed(const Surface& surface, const IntervalVec3& box) {
  const auto over = surface.enclose(box);
  IntervalVec3 middle, step;
  for (std::size_t i = 0; i < 3; ++i) {
    middle[i] = box[i].middle();
    step[i] = box[i] - middle[i];
  }
  const auto at = surface.enclose(middle);
  const auto meet = [](const Interval& a, const Interval& b) {
    const Interval both = intersection(a, b);
    return both.empty() ? a : both;  // rounding alone parts them
  };
  NarrowedEnclosure out{at.g, at.gradient};
  for (std::size_t k = 0; k < 6; ++k) {
    const auto [i, j] = kPackedIndices[k];
    const auto row = static_cast<std::size_t>(i), column = static_cast<std::size_t>(j);
    out.gradient[row] += over.hessian[k] * step[column];
    if (row != column) out.gradient[column] += over.hessian[k] * step[row];
  }
  for (std::size_t i = 0; i < 3; ++i) {
    out.gradient[i] = meet(over.gradient[i], out.gradient[i]);
    out.g += out.gradient[i] * step[i];
  }
  out.g = meet(over.g, out.g);
  return out;
}

}  // namespace caustic::geometry
