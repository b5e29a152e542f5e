// The map x ↦ q of one hop over whole cells of the first surface, enclosed by intervals: what
// certification of contours asks. NOTATION.md (S70)–(S72).
#pragma once

#include <vector>

#include "geometry/graph_cover.h"
#include "geometry/interval_jet.h"
#include "solver/forward_map.h"

namespace caustic::solver {

using geometry::Interval;

/// That of all numbers of an interval; 0 if it holds zero.
inline int sign_of(const Interval& a) { return a.lo > 0.0 ? 1 : a.hi < 0.0 ? -1 : 0; }

/// A cell of a chart, s and t its two coordinates; on the surface the third one lies in z.
struct GraphCell {
  Interval s, t, z;
  bool whole = false;  ///< the surface is proven to lie over all of the cell
};

/// A function on a cell and its derivatives along s and t.
struct Slopes {
  Interval v, s, t;
};

/// What is known of one cell. Values are the tighter of natural and mean value forms (S72).
struct EnclosedField {
  bool dark = false;     ///< no light of this family comes from here and arrives in the window
  bool regular = false;  ///< all below is enclosed: no pole and no total reflection in the cell
  Slopes a, flux;        ///< A and Σ of (S71)
  std::vector<Slopes> bounds;  ///< positive where nothing counts (S74)
  Interval a_middle, flux_middle, ds, dt;

  /// F = A − kΣ: the level function, times something positive.
  Slopes level(double k) const;
};

class EnclosedMap {
 public:
  /// False for families that this does not know how to enclose.
  static bool encloses(const ForwardMap& map);

  explicit EnclosedMap(const ForwardMap& map);

  const ForwardMap& map() const { return map_; }
  /// Narrows z to what the surface takes over the cell (interval Newton); false if it is not there.
  bool narrow(const geometry::GraphChart& chart, GraphCell& cell) const;
  void enclose(const geometry::GraphChart& chart, const GraphCell& cell, EnclosedField& f) const;

 private:
  class Trail;
  struct Result;
  void follow(const geometry::GraphChart& chart, const GraphCell& cell, Trail& trail,
              Result& out) const;
  Slopes bound(const geometry::Bound& b, const geometry::IntervalVecJet& x) const;

  const ForwardMap& map_;
  const geometry::Surface& shape_;
  const Optics& optics_;
  bool point_source_;
  Vec3 source_;  // position or direction
};

}  // namespace caustic::solver
