// One specimen of every shape and class that the program knows, described by its parameters, so
// that the surface under test and the 50-digit reference are built from the same numbers.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "geometry/sag.h"
#include "geometry/surface.h"

namespace caustic::test {

struct ShapeSpec {
  enum class Kind {
    plane,
    sphere,
    ellipsoid,
    quadric,
    cylinder,
    cone,
    torus,
    conic,
    revolution,
    sag,
    zernike,
    heights,
    expression
  };

  std::string name;
  Kind kind = Kind::plane;
  geometry::Point point = geometry::Point::Zero();  ///< centre, apex, vertex, point on the axis
  geometry::Direction axis = geometry::Vec3::UnitZ();
  geometry::Mat3 rotation = geometry::Mat3::Identity();  ///< ellipsoid, height fields
  geometry::Vec3 semi_axes = geometry::Vec3::Ones();     ///< ellipsoid
  double radius = 1.0;  ///< sphere, cylinder; half angle of the cone; major one; R of the conic;
                        ///< height of the revolution
  double second = 0.0;  ///< minor radius, conic constant
  std::array<double, 10> coefficients{};  ///< quadric
  std::vector<double> aspheric{};         ///< conic
  std::vector<double> profile{};          ///< revolution
  struct Term {
    int i, j;
    double c;
  };
  std::vector<Term> terms{};                      ///< sag: c x^i y^j
  std::vector<std::pair<int, double>> zernike{};  ///< over the disc of `radius`
  geometry::HeightGrid grid{};                    ///< heights
  std::string expression{};  ///< in a cube of half size `radius`, lengths in `unit`
  double unit = 1.0;         ///< m
  geometry::Pose pose{};     ///< x_world = R x + t, applied to all of the above
};

std::ostream& operator<<(std::ostream& out, const ShapeSpec& spec);

/// The surface under test, the pose applied to its parameters.
geometry::SurfacePtr build(const ShapeSpec& spec);

/// All shapes, of size one, rotated and shifted by a pose of order one.
const std::vector<ShapeSpec>& shape_zoo();

/// Surfaces given by expressions, in the same way.
const std::vector<ShapeSpec>& expression_zoo();

/// The same shape, lengths multiplied by `factor`.
ShapeSpec scaled(const ShapeSpec& spec, double factor);

/// Coefficients of Σ λᵢ yᵢ² + 2ℓ y₂ + k with y = Rᵀ(x − o).
std::array<double, 10> quadric_coefficients(const geometry::Vec3& lambda, double linear,
                                            double constant, const geometry::Mat3& axes,
                                            const geometry::Point& origin);

}  // namespace caustic::test
