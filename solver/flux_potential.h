// The flux through a part of the first surface as a line integral round it (S60).
#pragma once

#include <optional>

#include "solver/family_field.h"
#include "solver/mean_share.h"

namespace caustic::solver {

/// Of one explored family.
class FluxPotential {
 public:
  FluxPotential(const FamilyField& field, const Light& light);

  /// A(x)[dx], W; the error is that of the mean share.
  Estimate along(const Point& x, const Vec3& dx) const;
  /// An exact form of the same size, which vanishes round anything that is closed, W.
  Vec3 closing(const Point& x, const Vec3& dx) const;

  /// Where A has its pole, if that is a place that light may reach: then `pole_flux` is missing
  /// round a region which holds it.
  const std::optional<FieldPoint>& pole() const { return pole_; }
  double pole_flux() const { return 4.0 * geometry::kPi * strength_; }
  /// The family cannot bring more, W.
  double power() const {
    return (point_source_ ? 4.0 : reach_ * reach_) * geometry::kPi * strength_;
  }
  /// With a share that varies it is not.
  bool lacks_pole_flux() const { return pole_ && share_; }

 private:
  void turn_away(const FamilyField& field);
  void move_to_middle(const FamilyField& field);

  bool point_source_;
  double strength_;     // ρI, W/sr, or ρE_b, W/m²
  Vec3 source_;         // position of a point source, direction of a beam
  Vec3 axis_;           // b of a point source, c of a beam
  double reach_ = 0.0;  // of a beam: largest |x − c|, m
  std::optional<FieldPoint> pole_;
  std::optional<MeanShare> share_;  // where ρ is not constant
};

}  // namespace caustic::solver
