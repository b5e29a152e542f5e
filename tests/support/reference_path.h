// Specular paths in 50 digits, by shooting: rays are sent from one end, reflected and refracted by
// the law of Snell, until one meets the other end. Nothing of Fermat's equations is used.
#pragma once

#include <array>
#include <vector>

#include "tests/support/shape_zoo.h"

namespace caustic::test {

struct ReferenceVertex {
  ShapeSpec shape;
  bool reflects = true;
  double index_before = 1.0, index_after = 1.0;
};

struct ReferencePath {
  std::vector<geometry::Point> x;
  std::vector<geometry::Mat3> jacobians;                ///< ∂xᵢ/∂to
  std::vector<std::array<geometry::Mat3, 3>> hessians;  ///< [i][a](b, c)
  double optical_length;
  double determinant;  ///< area across the ray at `to` per solid angle, sign: see NOTATION (S34)
};

/// `x` are starting values good to about 1e-8.
ReferencePath reference_path(const std::vector<ReferenceVertex>& hops, const geometry::Point& from,
                             const geometry::Point& to, const std::vector<geometry::Point>& x);

}  // namespace caustic::test
