// The share of the light that a family passes on, where it varies by Fresnel's equations, averaged
// over the rays between an axis and a point: what the flux potential has to be multiplied by (S65).
#pragma once

#include "solver/analysis.h"
#include "solver/forward_map.h"

namespace caustic::solver {

class MeanShare {
 public:
  /// The map must outlive it. `axis` is a unit vector from a point source, a point on the middle
  /// ray of a beam.
  MeanShare(const ForwardMap& map, const Vec3& axis);

  /// ∫ share 2ν dν over the rays at the share ν of the way from the axis to that of x.
  Estimate at(const Point& x) const;

 private:
  double on_ray(const geometry::Ray& ray) const;

  const ForwardMap& map_;
  Vec3 axis_;
  double reach_;  // of rays, m
};

}  // namespace caustic::solver
