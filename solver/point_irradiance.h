// What a light meter reads at a point of the receiver: the sum over all paths that arrive there,
// each with its own share. NOTATION.md (S7).
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "solver/find_paths.h"
#include "solver/forward_map.h"

namespace caustic::solver {

/// Light by one path.
struct SheetIrradiance {
  int family_id;  ///< kDirectFamily: straight from the source
  int parity;     ///< sign of a
  double E;       ///< W/m²
  Vec3 gradient;  ///< ∇E along the receiver, world axes, W/m³
  Point x;        ///< where it comes first: its first hit, or the place itself
  std::vector<Point> hits;
};

struct PointIrradiance {
  /// On a caustic: two or more paths fall into one and E is unbounded. `E` and `gradient` are then
  /// 0.
  bool on_caustic = false;
  double E = 0.0;  ///< sum over sheets, and the direct light if asked for
  Vec3 gradient = Vec3::Zero();
  std::vector<SheetIrradiance> sheets;
};

class LightMeter {
 public:
  /// The system must outlive it. No families: every surface that passes light on, by itself.
  LightMeter(const OpticalSystem& system, const std::vector<Family>& families, bool direct);

  /// q in receiver axes, m. Questions near each other share work; not thread-safe.
  PointIrradiance at(const Vec2& q);

 private:
  const ForwardMap& map_of(int family, const std::vector<Point>& hits);
  void add(int family, const FieldPoint& f, std::vector<Point> hits, PointIrradiance& sum) const;
  void add_direct(const Point& p, PointIrradiance& sum) const;

  const OpticalSystem& system_;
  std::optional<ForwardMap> direct_;
  std::vector<Family> families_;
  std::vector<PathFinder> finders_;
  std::map<std::pair<int, Hops>, std::unique_ptr<ForwardMap>> maps_;
};

}  // namespace caustic::solver
