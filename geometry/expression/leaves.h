// The zero set of a field in a box, cut into pieces that are graphs over two of the coordinates.
#pragma once

#include <vector>

#include "geometry/expression/field.h"

namespace caustic::geometry {

/// A box on which the field is defined and ∂g/∂x_axis has one sign: along that axis it has one zero
/// at most.
struct Leaf {
  Box box;
  int axis;
};

struct Leaves {
  std::vector<Leaf> graphs;
  /// Boxes given up: a singular point (∇g = 0), the end of the domain, or too many boxes.
  std::vector<Box> undecided;
  bool defined_somewhere = false;
};

/// Fewer and larger leaves of the same surface: neighbours become one where that is a graph and the
/// surface in it is all theirs.
std::vector<Leaf> merged(const Field& field, const Leaves& leaves);

/// Outside of all of these boxes the field has no zero in `bounds`.
Leaves cut_into_graphs(const Field& field, const Box& bounds);

/// Point over the relative coordinates (s, t) in the leaf's rectangle. Where the surface leaves the
/// box it goes on with a continuous slope (S18).
Point graph_point(const Field& field, const Leaf& leaf, double s, double t);
/// True if the surface is in the leaf's box there.
bool graph_exists(const Field& field, const Leaf& leaf, double s, double t);

}  // namespace caustic::geometry
