// The curves on the receiver across which the number of sheets changes: images of caustics and of
// the boundaries of families and of what hides their light, traced by the code that traces levels,
// and the edges of the receiver (S51), (S57).
#pragma once

#include <vector>

#include "solver/branches.h"

namespace caustic::solver {

struct BoundaryCurve {
  BoundaryKind kind;
  int field = -1;               ///< −1 for the receiver's edges
  int boundary = -1;            ///< of the field's domain, or −1
  bool closed = false;          ///< then the first vertex is not repeated
  std::vector<Vec2> q;          ///< vertices, receiver axes, m
  std::vector<FieldPoint> own;  ///< the sheet's points; empty for the receiver's edges
  std::shared_ptr<const HiddenEdge> edge = nullptr;  ///< of what hides
  int mate = -1;  ///< field of another family's sheets that begin there too (shared_edges.h), or −1

  bool on_receiver_edge() const { return kind == BoundaryKind::receiver; }
  LevelFunction function(const FamilyField& f) const {
    if (edge) return LevelFunction::edge_of(*edge);
    return boundary < 0 ? LevelFunction::caustic() : LevelFunction::boundary_of(f.domain, boundary);
  }
};

/// The surface that meets the receiver's plane along the curve's image, where light ends by way of
/// it or is hidden by it; −1 of other curves. Those of one surface have one image (S84).
int contact_of(const SheetCarrier& carrier, const BoundaryCurve& curve);

/// Where sheets begin at a place of a curve (not of the receiver's edges).
struct Opening {
  bool real;    ///< false if they are hidden there, so that nothing begins
  Vec3 inside;  ///< direction along the first surface to where they are; either way from a caustic
};
/// Visibility is asked beside the curve, `share` of the scene away from it.
constexpr double kOpeningStep = 1e-6;
Opening opening_at(SheetCarrier& carrier, const BoundaryCurve& curve, const FieldPoint& at,
                   double share = kOpeningStep);

/// Of the report in the answer.
BoundaryKind kind_of(Ending ending);
/// True if all of the curve lies on a boundary of the domain before its own number: boundaries may
/// coincide, such as the rim of an aperture in the receiver's plane with that plane.
bool coincides_with_domain(const FamilyField& field, const BoundaryCurve& curve);
struct BoundaryCurves {
  std::vector<BoundaryCurve> curves;
  std::size_t unresolved = 0;  ///< places where a boundary could not be found or followed
};

/// The traces of one function.
BoundaryCurves curves_along(SheetCarrier& carrier, int field, BoundaryKind kind,
                            const LevelFunction& function, std::vector<Seed> seeds, Budget& budget,
                            double chord, double residual);

/// Polylines within `chord` (m) of the curves, complete as far as the exploration of the fields is,
/// or the seeds: of each field, on its caustic (target −1) and its domain's boundaries (their
/// numbers). The receiver's four edges come last, counterclockwise.
BoundaryCurves trace_boundaries(SheetCarrier& carrier, Budget& budget, double chord,
                                double residual, const std::vector<std::vector<Seed>>& seeds = {});

}  // namespace caustic::solver
