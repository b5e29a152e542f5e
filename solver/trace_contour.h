// One component of one contour: from a seed in both directions, until it closes or ends.
#pragma once

#include <vector>

#include "solver/contours.h"
#include "solver/domain.h"
#include "solver/evaluator.h"
#include "solver/level_function.h"

namespace caustic::solver {

struct TraceOptions {
  double chord = 0.0;      ///< largest distance polyline–curve on the receiver, m
  double residual = 1e-11; ///< what the corrector aims at
  double first_step = 0.0; ///< on the mirror, m
};

struct Trace {
  std::vector<CurveVertex> vertices;  ///< arc_length not yet filled in
  std::vector<Vec3> tangents;         ///< unit tangents on the mirror, along the order of vertices
  std::vector<std::shared_ptr<const Hit[]>> hits;  ///< of the vertices; empty for a single mirror
  bool closed = false;
  std::vector<Ending> ends;   ///< at the first and the last vertex; none if closed
  bool clipped = false;       ///< an end lies on the clip ball
  bool stalled = false;       ///< an end is `limit` although the budget was not exhausted
  double conditioning = 0.0;  ///< largest residual that the rounding of x alone explains
};

/// `seed` lies on the curve, inside the domain or on its boundary.
Trace trace_contour(Evaluator& evaluate, const Domain& domain, const LevelFunction& level,
                    const FieldPoint& seed, const TraceOptions& options);

/// A point of the curve as the files have it.
CurveVertex make_vertex(const ForwardMap& map, const LevelFunction& level, const FieldPoint& f);

}  // namespace caustic::solver
