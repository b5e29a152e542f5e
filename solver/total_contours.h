// The edge of {E_total ≥ level} on the receiver: level arcs and jump arcs that close to rings with
// the brighter side on the left. NOTATION.md (S50)–(S55).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "solver/contours.h"
#include "solver/family_field.h"
#include "solver/total_arcs.h"

namespace caustic::solver {

/// What of the total of these explored fields this version cannot trace; nothing if it can.
std::optional<std::string> total_unsupported(const std::vector<const FamilyField*>& fields);

struct TotalContours {
  std::vector<Curve> curves;  ///< rings numbered, not yet sorted
  std::vector<Curve>
      boundaries;  ///< if wanted: pieces along which the sheets on either side are the same
  std::vector<CriticalPlace> critical_points;  ///< if wanted
  std::vector<Region> regions;                 ///< if wanted
  std::size_t unresolved =
      0;  ///< boundary pieces, arcs and rings that could not be followed or closed
};

/// What else than levels is wanted.
struct TotalExtras {
  bool boundaries = false, critical_points = false, regions = false;
  bool any() const { return boundaries || critical_points || regions; }
};

/// Looks on while a total is traced, at everything with all its sheets.
class TotalObserver {
 public:
  virtual ~TotalObserver() = default;
  /// Before the first level. All three stay as they are until the last has been traced.
  virtual void boundaries(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves,
                          const BoundaryPieces& pieces) = 0;
  /// A level's nodes and parts of boundaries, then its arcs.
  virtual void level_on_boundaries(double level, const LevelOnBoundaries& found) = 0;
  virtual void level_arc(double level, const LevelArc& arc) = 0;
  /// With what of the level could not be followed or closed.
  virtual void level_traced(double level, std::size_t unresolved) = 0;
};

struct TotalCertificate;

/// `levels` ascending, W/m²; `chord` m; `residual` as for sheets. Fields must be explored. Besides
/// what it finds itself it traces what the certificate has seeds on. This and the observer may be
/// null.
TotalContours trace_total(const OpticalSystem& system,
                          const std::vector<const FamilyField*>& fields,
                          const std::vector<double>& levels, double chord, double residual,
                          const TotalExtras& extras, Budget& budget,
                          TotalObserver* observer = nullptr,
                          const TotalCertificate* certificate = nullptr);

}  // namespace caustic::solver
