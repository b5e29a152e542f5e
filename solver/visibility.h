// What surfaces hide: the way from the light to the first surface (shadow), from each surface to
// the next and from the last to the receiver (occlusion), by any surface, those of the path
// included. Decided in double precision on the exact surfaces; Embree proposes candidates where
// there are many.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "geometry/embree_scene.h"
#include "solver/contours.h"
#include "solver/forward_map.h"
#include "solver/room.h"

namespace caustic::solver {

/// Many surfaces or few: below this number asking each is faster than Embree (tests/bench).
constexpr int kEmbreeSurfaces = 8;

/// Where light goes: its hits and its arrival on the receiver.
struct LightPath {
  std::array<Point, kMaxHops + 1> at;
  int count = 0;

  /// `hits` as in FieldPoint.
  LightPath(const ForwardMap& map, const Point& x, const Hit* hits, const Point& p);
  LightPath(const ForwardMap& map, const FieldPoint& f)
      : LightPath(map, f.x, f.hits.get(), map.receiver().point(f.q)) {}
  const Point& x() const { return at[0]; }
};

/// What is seen of one path, and how far from it that holds (S13).
struct Sight {
  bool hidden = false;
  Ending ending = Ending::shadow;  ///< by what kind of segment it is hidden, or could be
  /// Of the segment that ends at point j of the path; the first begins at the light.
  std::array<RoomUse, kMaxHops + 1> use{};

  /// The share of the room used by moving from the path that was looked at to another one.
  double used(const LightPath& from, const LightPath& to) const;
};

/// As much of its room is taken for free: it is a lower bound to second order only.
constexpr double kUsableRoom = 1.0 / 1.2;

class Visibility {
 public:
  /// `candidates` may be null: then every surface is asked. Surfaces whose box is further away than
  /// `margin` (m) count as that far.
  Visibility(const OpticalSystem& system, const geometry::EmbreeScene* candidates, double margin);

  Sight look(const Hops& hops, const LightPath& path) const;
  bool hidden(const Hops& hops, const LightPath& path) const { return look(hops, path).hidden; }

  /// A place where a path meets a surface that is not the one it goes to.
  struct Meeting {
    int segment;  ///< 0 from the light to the first surface, and so on
    int surface;
    Point y;
    double margin;  ///< distance from the aperture's edge, m; ≤ 0 where the surface exists
  };
  /// All of them, also where surfaces do not exist.
  std::vector<Meeting> meetings(const Hops& hops, const LightPath& path) const;

 private:
  struct Way {
    std::array<Segment, kMaxHops + 1> segments;
    int count = 0;
  };
  Way way(const Hops& hops, const LightPath& path) const;
  bool free_of_own(const Segment& segment, int surface) const;
  void crossings(const Segment& segment, int surface, geometry::RayParameters& out) const;
  Room room(const Segment& segment) const;
  RoomUse room_beside(const Segment& segment) const;
  Room room(const Segment& segment, int surface) const;

  const OpticalSystem& system_;
  const geometry::EmbreeScene* candidates_;
  double margin_;
};

/// Visibility of paths that are asked for near each other: what is seen of one holds for its
/// neighbours.
class Lookout {
 public:
  Lookout(const Visibility& visibility, const Hops& hops) : visibility_(visibility), hops_(hops) {}
  bool hidden(const LightPath& path);

 private:
  static constexpr std::size_t kRemembered = 8;

  const Visibility& visibility_;
  const Hops& hops_;
  std::vector<std::pair<LightPath, Sight>> seen_;
  std::size_t oldest_ = 0;
};

}  // namespace caustic::solver
