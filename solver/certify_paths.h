// All specular paths from a light to a point, proven to be all: interval Newton by Krawczyk's operator
// in a branch and bound over the surfaces. [MH] §5.3; NOTATION.md (S38)–(S42).
#pragma once

#include <cstddef>
#include <vector>

#include "geometry/linear.h"
#include "solver/budget.h"
#include "solver/pencil.h"

namespace caustic::solver {

struct CertifyOptions {
  /// Boxes looked at before the rest is given up as undecided.
  std::size_t max_boxes = 500000;
  /// Boxes smaller than this share of the scene are not divided: what is left there is a double
  /// root, a path that grazes, or a whole curve of paths.
  double smallest = 1e-7;
  /// Its end gives up the rest too; may be null.
  Budget* budget = nullptr;
};

struct CertifiedRoots {
  /// x₁ … x_N of each root of Fermat's equations that the optics obeys: each proven to exist, to be
  /// alone in its box, and all different. Apertures and visibility are not looked at.
  std::vector<std::vector<Point>> roots;
  /// Boxes that could be neither emptied nor shown to hold one root. If there are none, `roots` are
  /// all that there are.
  std::size_t undecided = 0;
  std::size_t boxes = 0;
};

/// `regions[i]` holds all of surface i that exists; its bounds only help to discard.
CertifiedRoots certify_paths(const std::vector<PathSurface>& surfaces,
                             const std::vector<geometry::Box>& regions, const Light& light,
                             const Point& to, double scale, const CertifyOptions& options = {});

}  // namespace caustic::solver
