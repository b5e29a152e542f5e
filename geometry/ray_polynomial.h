// Crossings of surfaces whose g is a polynomial along a ray.
#pragma once

#include "geometry/linear.h"
#include "geometry/root_finding.h"

namespace caustic::geometry {

enum class Along { crossings, stationary };

/// Appends the τ in [t0, t1] where g along the ray is zero, or stationary, in increasing order.
/// `polynomial(ray)` gives g as a polynomial of a ray's parameter. It is asked for the same ray started
/// at the point nearest to `center`: from afar the coefficients would grow with the square of the
/// distance and cancel, from there they stay as small as the surface.
template <class MakePolynomial>
void roots_along(const MakePolynomial& polynomial, const Ray& ray, const Point& center, Along what,
                 double t0, double t1, std::vector<double>& out) {
  const double shift = ray.nearest(center);
  const Polynomial p = polynomial(Ray{ray.at(shift), ray.direction});
  const std::size_t first = out.size();
  real_roots(what == Along::stationary ? p.derivative() : p, t0 - shift, t1 - shift, out);
  for (std::size_t i = first; i < out.size(); ++i) out[i] += shift;
}

}  // namespace caustic::geometry
