// A chart maps the unit square onto a part of a surface. Exploration subdivides the square; points
// lie on the surface to rounding, unless outside of the chart's cell.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "geometry/aperture.h"
#include "geometry/linear.h"

namespace caustic::geometry {

struct Chart {
  /// (s, t) in [0,1]² → a point of the surface.
  std::function<Point(double s, double t)> point;
  /// Half-spaces inside of which the chart counts; charts of one surface meet there without a gap.
  /// Points outside go on smoothly, but may lie off the surface. Empty: all of the square counts.
  std::vector<Bound> cell = {};
};

/// What charts have to cover: a bounded box, resolved to `scale` about `focus` and coarser away
/// from it, since an unbounded mirror is explored in a ball a thousand times the scene.
struct Extent {
  Box region;
  Point focus;
  double scale;
};

/// The range of the coordinate (x − origin)·axis over extent.region as an image of [0, 1]:
/// focus + scale·sinh(α), linear in α.
class GradedRange {
 public:
  GradedRange(const Extent& extent, const Point& origin, const Direction& axis)
      : scale_(extent.scale), focus_((extent.focus - origin).dot(axis)) {
    const double middle = (extent.region.center() - origin).dot(axis);
    const double half = 0.5 * (extent.region.max - extent.region.min).dot(axis.cwiseAbs());
    begin_ = std::asinh((middle - half - focus_) / scale_);
    end_ = std::asinh((middle + half - focus_) / scale_);
  }
  double operator()(double w) const {
    return focus_ + scale_ * std::sinh(begin_ + w * (end_ - begin_));
  }

 private:
  double scale_, focus_, begin_, end_;
};

}  // namespace caustic::geometry
