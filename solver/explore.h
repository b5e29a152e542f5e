// Adaptive subdivision of the lit part of one mirror: which cells send light into the receiver's
// window, refined until the field varies slowly on each. It depends on the scene alone, so that all
// levels, limits and tolerances share it.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "solver/domain.h"
#include "solver/evaluator.h"

namespace caustic::solver {

/// A corner of a cell's part inside the domain: a place in the chart, evaluated.
struct Corner {
  double s, t;
  int sample;
  int boundary = -1;  ///< of the domain, on which the edge to the next corner lies; −1 inside,
                      ///< kPathEnds where it runs along the end of all paths
};
constexpr int kPathEnds = -2;

/// A cell at the end of the subdivision, clipped to the domain.
struct Cell {
  int chart;
  std::vector<Corner> polygon;  ///< in order around the cell; not empty
  bool whole;                   ///< not clipped: four corners
  int center;                   ///< sample in the middle of the unclipped cell
  double radius;                ///< about the centre, m
  double hidden = 0.0;          ///< share of the samples in the domain that something hides
};

struct Exploration {
  std::vector<geometry::Chart> charts;
  std::vector<FieldPoint> samples;
  std::vector<Cell> cells;
  std::size_t discarded = 0;   ///< cells that nothing of the image can come from
  std::size_t unresolved = 0;  ///< cells given up at the finest subdivision
  bool dark = true;            ///< no sample is lit: the light never reaches the mirror
};

/// True if what the light does at this point is hidden by some surface.
using Hidden = std::function<bool(const FieldPoint&)>;

/// `hidden` may be empty: then nothing is. `unseen_too`: cells that send nothing to the receiver
/// are refined like the others before they are discarded.
Exploration explore(Evaluator& evaluate, const Domain& domain, const OpticalSystem& system,
                    const Hidden& hidden, bool unseen_too = false);

/// Point of a chart, evaluated and stored.
int add_sample(Exploration& e, Evaluator& evaluate, int chart, double s, double t);

/// Area of the polygon's image on the receiver, m².
double image_area(const Exploration& e, const Cell& cell);

}  // namespace caustic::solver
