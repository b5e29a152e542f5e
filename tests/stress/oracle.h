// What is asked of the oracle: readings in 50 digits, and rays through the whole scene, with what
// they meet first, in long double.
#pragma once

#include <optional>
#include <set>
#include <vector>

#include "solver/contours.h"
#include "tests/stress/oracle_map.h"
#include "tests/stress/oracle_roots.h"
#include "tests/support/random.h"

namespace caustic::stress {

/// One path, by a bundle of rays about it.
struct Reading {
  Vec2 q;
  double E;
  int parity;       ///< orientation of the image
  double flatness;  ///< |det|/(|∇u||∇v|): 0 on a caustic
};

/// How much a reading changes when x moves by no more than rounding does.
struct Spread {
  double q, E, flatness;  ///< E relative
};

/// Light that arrives in the window.
struct Arrived {
  Family family;
  Point x;  ///< first hit
  Reading reading;
};

class Oracle {
 public:
  explicit Oracle(const json& scene);

  const OracleScene& scene() const { return scene_; }
  double size() const { return scene_.size; }

  /// Distances from hop to hop of the path from x whose image is nearest to q; empty if none is.
  std::vector<double> distances(const Family& family, const Point& x, const Vec2& q) const;
  std::optional<Reading> exact(const Family& family, const Point& x,
                               const std::vector<double>& near) const;
  /// In long double: good to some 1e-11, as far as the path is not nearly singular.
  std::optional<Reading> quick(const Family& family, const Point& x,
                               const std::vector<double>& near) const;
  Spread spread(const Family& family, const Point& x, const std::vector<double>& near,
                const Reading& base) const;
  /// ∇E in the receiver's axes, by 50-digit differences between paths next to each other; nothing
  /// where one of them does not arrive or the map is singular.
  std::optional<Vec2> slope(const Family& family, const Point& x,
                            const std::vector<double>& near) const;
  double surface_distance(int surface, const Point& x) const;

  /// Signs of ∇g·ω at each hop: the sides from which light comes.
  std::vector<int> sides(const Family& family, const Point& x,
                         const std::vector<double>& near) const;
  /// What keeps the path from x, by these sides, from existing: the ends that are true there.
  std::set<solver::Ending> broken(const Family& family, const Point& x,
                                  const std::vector<double>& near,
                                  const std::vector<int>& sides) const;

  /// What arrives of a ray of the light towards a point: after each hop, if nothing is in the way.
  std::vector<Arrived> shoot(const Point& towards, std::size_t max_hops, bool direct) const;

 private:
  std::vector<Long> roots(int surface, const LongVec& o, const LongVec& w, Long t0, Long t1,
                          Long slack = 0.0L) const;
  std::vector<LongVec> hits_of(const Family& family, const Point& x,
                               const std::vector<double>& near, std::vector<int>& sides,
                               PathMap<Long>::Fate& fate, Vec2& q) const;
  bool blocked(const LongVec& a, const LongVec& b, int on_a, int on_b) const;
  std::optional<Reading> reading_at(const Family& family, const LongVec& x,
                                    const std::vector<Long>& near) const;

  OracleScene scene_;
  PathMap<Long> quick_;
  PathMap<test::Real> exact_;
};

}  // namespace caustic::stress
