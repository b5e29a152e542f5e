// Area of a region of the receiver and flux onto it, by line integrals along its edge (S61) to
// (S63).
#pragma once

#include <vector>

#include "solver/analysis.h"
#include "solver/arc_points.h"
#include "solver/flux_potential.h"
#include "solver/total_nodes.h"

namespace caustic::solver {

struct RegionIntegrals {
  Estimate area;               ///< m²
  Estimate flux;               ///< W
  std::size_t unresolved = 0;  ///< segments that could not be followed, edges that do not close
};

class RegionIntegrator {
 public:
  RegionIntegrator(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves);

  /// What of these fields it cannot do; nothing if it can.
  std::optional<std::string> unsupported() const;
  /// Of everything that reaches the receiver; the area is the receiver's.
  RegionIntegrals all(const BoundaryPieces& pieces);
  /// A region begins with its boundaries; its level arcs follow.
  void begin(double level, const LevelOnBoundaries& found);
  void add(const LevelArc& arc);
  /// What has been added since the region began. Where something of its edge is unresolved, errors
  /// are what is sure without it: no more than all of the receiver, and of the light.
  RegionIntegrals result(std::size_t unresolved);

 private:
  // Area, flux, what rounding of x moves the area by, what the flux is off by where shares vary,
  // ∮dq, Σ∮s of exact forms.
  using Density = Eigen::Matrix<double, 9, 1>;
  // What counts along a boundary: sheets that go on across it, those that begin inside of it, those
  // that begin outside. Turned, the region is on the outside.
  struct Count {
    bool others, inside, outside, area;
    bool turned = false;
  };

  void add_sheet(const Branch& sheet, const Vec3& dx, Density& sum) const;
  Density level_density(const ArcPoint& at) const;
  Density boundary_density(const ArcPoint& at, int field, const Count& count) const;
  void add(const BoundaryCurve& curve, const std::vector<BoundaryVertex>& vertices, bool closed,
           const Count& count);
  template <class DensityAt>
  void integrate(const DensityAt& density_at, double begin, double end, int depth = 0);
  double flux_beyond_poles() const;

  SheetCarrier& carrier_;
  const std::vector<BoundaryCurve>& curves_;
  std::vector<FluxPotential> potentials_;  // of each field
  std::vector<double> pole_totals_;        // E_tot where a potential has its pole
  double area_scale_, flux_scale_ = 0.0;
  double most_flux_ = 0.0;  // what is sure not to be exceeded, W
  double level_ = 0.0;
  Density sum_, errors_;
  std::size_t unresolved_ = 0, points_ = 0;
  bool unsure_ = false;  // of the boundaries, which all regions share
};

}  // namespace caustic::solver
