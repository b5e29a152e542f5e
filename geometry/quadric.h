// Quadrics in a frame of their own: g = ½ Σ λᵢ yᵢ² + ℓ·y + k, y = axesᵀ (x − origin).
#pragma once

#include "geometry/surface.h"

namespace caustic::geometry {

struct QuadricForm {
  Point origin;
  Mat3 axes;     ///< columns: an orthonormal frame
  Vec3 lambda;   ///< 1/m
  Vec3 linear = Vec3::Zero();  ///< ℓ
  double constant = 0.0;       ///< k, m
};

using ChartMaker = std::function<std::vector<Chart>(const Extent&)>;

/// A quadric whose charts are made by `charts`. `box` bounds it, `bounds` are the shape's own.
SurfacePtr make_quadric_surface(const QuadricForm& form, ChartMaker charts, const Box& box,
                                std::vector<Bound> bounds = {});

/// Σ (yᵢ/aᵢ)² = 1.
ChartMaker ellipsoid_charts(const Point& center, const Mat3& axes, const Vec3& semi_axes);
/// (y₀/a)² + (y₁/b)² = c₀ + c₂ y₂²; c₀ = 0 is a cone, two charts that leave out its apex.
ChartMaker tube_charts(const Point& origin, const Mat3& axes, double a, double b, double c0,
                       double c2);
/// y₂ = height(y₀, y₁).
using Height = std::function<double(double, double)>;
ChartMaker sheet_charts(const Point& origin, const Mat3& axes, std::vector<Height> heights);

}  // namespace caustic::geometry
