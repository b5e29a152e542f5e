// A light, surfaces and a receiver, ready for tracing. Everything SI; immutable after build().
#pragma once

#include <string>
#include <vector>

#include "geometry/aperture.h"
#include "geometry/receiver_frame.h"
#include "geometry/surface.h"
#include "solver/light.h"
#include "solver/optics.h"

namespace caustic::solver {

struct SystemSurface {
  std::string name;
  geometry::SurfacePtr shape;
  /// The user's aperture. build() adds bounds of the shape and of the clip ball, and drops those
  /// that cut nothing off.
  std::vector<geometry::Bound> bounds;
  Optics optics;
  geometry::Box region{};  ///< set by build(): box of the part that exists
};

class OpticalSystem {
 public:
  /// Lengths in metres. Adds to each surface the bounds of its own shape and, where it is unbounded,
  /// of the clip ball: 10³ × the diameter of {receiver, bounded surfaces, point light} (api.md).
  static OpticalSystem build(Light light, std::vector<SystemSurface> surfaces,
                             geometry::ReceiverFrame receiver);

  /// The same surfaces, seen from another light.
  OpticalSystem with_light(Light light) const {
    OpticalSystem other = *this;
    other.light_ = std::move(light);
    return other;
  }

  const Light& light() const { return light_; }
  const std::vector<SystemSurface>& surfaces() const { return surfaces_; }
  const geometry::ReceiverFrame& receiver() const { return receiver_; }
  /// The receiver's plane, g < 0 on the side of −m; its region is the window. It is none of the
  /// surfaces: it blocks nothing, and light ends there.
  const SystemSurface& receiver_plane() const { return receiver_plane_; }
  /// Diameter of {receiver, bounded surfaces, point light}: the scale of the scene.
  double diameter() const { return diameter_; }
  const geometry::Point& center() const { return center_; }
  /// The box of all that exists of the surfaces.
  const geometry::Box& extent() const { return extent_; }
  /// So far from x every surface has been passed.
  double reach(const geometry::Point& x) const {
    return (extent_.center() - x).norm() + extent_.diagonal();
  }

 private:
  Light light_;
  std::vector<SystemSurface> surfaces_;
  geometry::ReceiverFrame receiver_;
  SystemSurface receiver_plane_;
  geometry::Point center_;
  geometry::Box extent_;
  double diameter_ = 0.0;
};

}  // namespace caustic::solver
