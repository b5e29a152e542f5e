// Which arcs of the total there are: seeds on every component of every level that does not meet a
// boundary, and on every component of the boundaries, proven by interval enclosures on a
// subdivision of the receiver. NOTATION.md (S77)–(S79).
#pragma once

#include <cstddef>
#include <vector>

#include "solver/certify_contours.h"
#include "solver/edge_roots.h"
#include "solver/mirror_cells.h"

namespace caustic::solver {

/// A rectangle of the receiver in which the arcs of these levels could not be told.
struct UndecidedPart {
  ReceiverCell part;
  std::vector<int> levels;
};

struct TotalCertificate {
  /// Of each field, on every component of its caustic (target −1) and of the domain's boundaries
  /// (target: the boundary's number) but the receiver's edges.
  std::vector<std::vector<Seed>> boundaries;
  std::vector<TotalSeed> arcs;
  std::vector<std::pair<int, UndecidedCell>> undecided_boundaries;  ///< by field
  std::vector<UndecidedPart> undecided;
  std::size_t cells = 0;
  bool exhausted = false;
};

/// All fields must be such that EnclosedMap encloses them. `levels` ascending, W/m².
TotalCertificate certify_total(const OpticalSystem& system,
                               const std::vector<const FamilyField*>& fields,
                               const std::vector<double>& levels, Budget& budget,
                               const ContourCertificateOptions& options = {});

}  // namespace caustic::solver
