// The map x ↦ q of one hop over whole cells of the first surface, enclosed by intervals: what
// certification of contours asks. NOTATION.md (S70)–(S72).
#pragma once

#include <array>
#include <vector>

#include "solver/enclosed_graph.h"
#include "solver/forward_map.h"

namespace caustic::solver {

/// A function on a cell and its derivatives along s and t.
struct Slopes {
  Interval v, s, t;
};

/// What is known of one cell. Values are the tighter of natural and mean value forms (S72).
struct EnclosedField {
  bool dark = false;     ///< no light of this family comes from here and arrives in the window
  bool regular = false;  ///< all below is enclosed: no pole and no total reflection in the cell
  int upward = 0;        ///< sign of ∇g along the chart's axis
  Slopes a, flux;        ///< A and Σ of (S71)
  /// Positive where nothing counts (S74): numbered as the boundaries of the Domain, then the two
  /// ends of the chart's box.
  std::vector<Slopes> bounds;
  std::array<Slopes, 2> q;  ///< where the light arrives, receiver axes
  std::array<Interval, 3>
      leaving;  ///< direction towards it along u, v, m, times something positive
  /// At the middle of the cell, and the distances of its points from there. Where no mean values
  /// could be taken (not centred) they are those of the cell, and 0.
  bool centred = false;
  Interval a_middle, flux_middle, ds, dt;
  std::array<Interval, 2> q_middle;

  /// F = A − kΣ: the level function, times something positive.
  Slopes level(double k) const;
};

class EnclosedMap {
 public:
  /// False for families that this does not know how to enclose.
  static bool encloses(const ForwardMap& map);

  explicit EnclosedMap(const ForwardMap& map);

  const ForwardMap& map() const { return map_; }
  bool narrow(const geometry::GraphChart& chart, GraphCell& cell) const {
    return solver::narrow(shape_, chart, cell);
  }
  /// How many of the bounds of a field, from the first, are those of the domain that are not the
  /// receiver's edges.
  int domain_bounds() const { return static_cast<int>(map_.mirror().bounds.size()) + 2; }
  void enclose(const geometry::GraphChart& chart, const GraphCell& cell, EnclosedField& f) const;

 private:
  struct Incident;
  struct Outgoing;
  struct Result;
  void follow(const geometry::GraphChart& chart, const GraphCell& cell, MeanValues& mean,
              Result& out) const;
  Incident incident(const GraphJets& on, MeanValues& mean) const;
  Slopes flux(const GraphJets& on, std::size_t axis, const Incident& in, MeanValues& mean) const;
  Outgoing bounce(const Incident& in, MeanValues& mean) const;
  void arrive(const GraphJets& on, const Incident& in, const Outgoing& leaving, MeanValues& mean,
              Result& out) const;
  Slopes bound(const geometry::Bound& b, const geometry::IntervalVecJet& x) const;

  const ForwardMap& map_;
  const geometry::Surface& shape_;
  const Optics& optics_;
  bool point_source_;
  Vec3 source_;  // position or direction
};

}  // namespace caustic::solver
