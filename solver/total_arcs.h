// Level arcs of the total irradiance, traced on the receiver with all sheets carried along (S54).
#pragma once

#include <vector>

#include "solver/total_nodes.h"

namespace caustic::solver {

struct ArcOptions {
  double level = 0.0;     ///< W/m²
  double chord = 0.0;     ///< largest distance polyline–curve, m
  double residual = 0.0;  ///< |E/level − 1| at which the corrector stops
};

struct ArcVertex {
  Vec2 q;
  Branches branches;
};

/// Brighter side on the left, u right, v up.
struct LevelArc {
  std::vector<ArcVertex> vertices;
  bool closed = false;   ///< the first vertex is not repeated
  bool stalled = false;  ///< could not be followed to a node
};

class ArcTracer {
 public:
  ArcTracer(SheetCarrier& carrier, const ArcOptions& options, Budget& budget);
  ~ArcTracer();

  /// From a node along the level to the next of `ends`, which is taken out, or round a closed arc.
  LevelArc follow(const Vec2& q, const Branches& branches, std::vector<TotalNode>& ends);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// True if q, a place of the level, lies on the arc.
bool on_arc(SheetCarrier& carrier, const LevelArc& arc, double level, const Vec2& q, double chord);

/// True at a node where the level, brighter side on the left, leaves into the node's side.
bool begins_arc(const TotalNode& node);

}  // namespace caustic::solver
