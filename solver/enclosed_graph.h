// A cell of a surface as a graph over two coordinates: where it is, and the jets of its points and
// normals over all of it. NOTATION.md (S70)–(S72).
#pragma once

#include <vector>

#include "geometry/graph_cover.h"
#include "geometry/interval_jet.h"

namespace caustic::solver {

using geometry::Interval;
using geometry::meet;

/// That of all numbers of an interval; 0 if it holds zero.
inline int sign_of(const Interval& a) { return a.lo > 0.0 ? 1 : a.hi < 0.0 ? -1 : 0; }

/// A cell of a chart, s and t its two coordinates; on the surface the third one lies in z.
struct GraphCell {
  Interval s, t, z;
  bool whole = false;  ///< the surface is proven to lie over all of the cell
};

/// Intermediate results in the order in which they come. What the middle of a cell gave narrows
/// what the whole of it gives, by mean values of the function and of its slopes (S72).
class MeanValues {
 public:
  /// What follows is recorded.
  void begin_middle();
  /// What follows is narrowed by what was recorded, at the distances ds, dt from there.
  void begin_cell(const Interval& ds, const Interval& dt);
  /// What follows is left as it is.
  void begin_alone();
  geometry::IntervalJet operator()(const geometry::IntervalJet& a);

 private:
  std::vector<geometry::IntervalJet> middle_;
  std::size_t next_ = 0;
  bool recording_ = false;
  Interval ds_{0.0}, dt_{0.0};
};

/// Narrows z to what the surface takes over the cell (interval Newton); false if it is not there.
bool narrow(const geometry::Surface& shape, const geometry::GraphChart& chart, GraphCell& cell);

/// x and N = ∇g along the coordinates of a cell; `upward` is the sign of N along the chart's axis,
/// 0 if it has both.
struct GraphJets {
  geometry::IntervalVecJet x, N;
  int upward;
};
GraphJets graph_jets(const geometry::Surface& shape, const geometry::GraphChart& chart,
                     const GraphCell& cell, MeanValues& mean);

}  // namespace caustic::solver
