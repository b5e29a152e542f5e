// Flux through the cells of an exploration (S15).
#pragma once

#include <vector>

#include "solver/explore.h"

namespace caustic::solver {

/// A sum over cells, W: ρI × the solid angle of a cell's polygon from the source, or ρE_b × its
/// area across the beam, and what goes between the chords and the curves that they stand for: lines
/// of the chart or the domain's boundary, by their tangents at the corners. Of fourth order in the
/// cells' size.
class FluxSum {
 public:
  FluxSum(const Exploration& exploration, const Domain& domain, const Light& light)
      : e_(exploration), domain_(domain), light_(light) {}
  void add(const Cell& cell, double weight);
  double value() const;

 private:
  struct Edge {
    int lo, hi;     // samples at its ends
    double weight;  // of the flux to the left of it from lo to hi
    const Cell* cell;
    std::size_t k;  // edge of that cell
  };
  double through_polygon(const Cell& cell) const;
  double beyond_chord(const Edge& edge) const;

  const Exploration& e_;
  const Domain& domain_;
  const Light& light_;
  double through_polygons_ = 0.0;
  std::vector<Edge> edges_;
};

}  // namespace caustic::solver
