// Which curves there are: seeds on every component of every level of one family, proven to be on
// all of them by interval enclosures on a subdivision of the first surface. NOTATION.md
// (S70)–(S76).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "solver/domain.h"
#include "solver/enclosed_map.h"
#include "solver/evaluator.h"
#include "solver/seeding.h"

namespace caustic::solver {

struct ContourCertificateOptions {
  /// Cells looked at before the rest is given up as undecided.
  std::size_t max_cells = 200000;
  /// Cells smaller than this share of the scene are not divided.
  double smallest = 1e-6;
};

/// A part of the first surface of which it could not be shown what curves are in it.
struct UndecidedCell {
  std::array<Point, 4>
      corners;               ///< in order around it; the diagonal of a box where it has no chart
  std::vector<int> targets;  ///< the level functions in question
};

struct ContourCertificate {
  /// On every component of every target inside the domain, where no cell is undecided.
  std::vector<Seed> seeds;
  std::vector<UndecidedCell> undecided;
  std::size_t cells = 0;
  bool exhausted = false;  ///< by max_cells or the request's own budget
};

/// The map must be one that EnclosedMap encloses. Targets may be boundaries of this domain.
ContourCertificate certify_contours(Evaluator& evaluate, const Domain& domain,
                                    const std::vector<LevelFunction>& targets,
                                    const ContourCertificateOptions& options = {});

}  // namespace caustic::solver
