// One lit side of one mirror, explored: the field that all levels of a request share.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "solver/levels.h"
#include "solver/plan.h"
#include "solver/seeding.h"
#include "solver/visibility.h"

namespace caustic::solver {

struct FamilyField {
  FamilyField(const OpticalSystem& system, const PlannedPiece& planned,
              const geometry::EmbreeScene* candidates, double margin);

  /// Explores, measures and finds critical points.
  void explore(Budget& budget);

  PlannedPiece piece;
  ForwardMap map;
  Domain domain;
  std::optional<Visibility> visibility;  ///< only where something may be hidden

  Exploration exploration;
  std::vector<CriticalPoint> critical;
  double flux = 0.0;  ///< W on the receiver's window
  std::vector<WeightedIrradiance> samples;
  double phi_min = 0.0, phi_max = 0.0;  ///< range of φ found, over lit and visible samples
  bool degenerate = false;    ///< a ≡ 0: all light goes through a point or a line of the receiver
  bool uniform = false;       ///< E is constant: no level curve
  bool seen = false;          ///< some of it reaches the window, and not all of that is hidden
  bool hidden_whole = false;  ///< what reaches the window is hidden, as far as gaps were sought
  bool empty() const { return !seen; }

 private:
  const OpticalSystem& system_;
  void measure();
};

}  // namespace caustic::solver
