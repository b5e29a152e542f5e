// Fermat's equations of a path and the law at its hits, enclosed over boxes: what certification of
// paths asks. NOTATION.md (S39), (S40), (S42).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "geometry/enclosure.h"
#include "solver/pencil.h"

namespace caustic::solver {

/// Where x₁ … x_N may be.
struct PathBox {
  std::array<geometry::IntervalVec3, kMaxHops> x;
};

/// The middle of such a box and two tangents there, of each hop.
struct PathMiddle {
  std::array<Point, kMaxHops> x;
  std::array<std::array<Vec3, 2>, kMaxHops> c;
};

class EnclosedPath {
 public:
  static constexpr int kMaxUnknowns = 3 * kMaxHops;
  using Values = std::array<geometry::Interval, kMaxUnknowns>;
  using Rows = std::array<Values, kMaxUnknowns>;

  /// `sides[i]` is ±1 where surface i refracts: the side, by the sign of g, that light comes from.
  EnclosedPath(const std::vector<PathSurface>& surfaces, const Light& light, const Point& to,
               double scale, const std::vector<int>& sides);

  int hops() const { return n_; }

  /// True if the box holds no path; otherwise it is cut down to where paths may be.
  bool impossible(PathBox& box);
  /// Whether Krawczyk's operator may contract the box: `impossible` has been asked of it just
  /// before.
  bool promising(const PathBox& box) const;
  /// (S41): a surface has but an isolated point here, or a sheet that closes.
  bool holds_only_a_point(const PathBox& box) const;

  /// False where a surface has no tangents.
  bool middle(const PathBox& box, PathMiddle& m) const;
  /// The 3N values of (S39) in the middle: two tangential ones and g for each hop.
  void values(const PathMiddle& m, Values& F);
  /// Their derivatives over the box; false where they do not say that V is along ∇g.
  bool derivatives(const PathBox& box, const PathMiddle& m, Rows& J);

 private:
  /// Unit direction w along the light, and (I − wwᵀ)/d.
  struct Segment {
    geometry::IntervalVec3 w;
    geometry::Interval bend[3][3];
  };
  static Segment between(const geometry::IntervalVec3& a, const geometry::IntervalVec3& b);

  void enclose(const PathBox& box);
  void enclose_segments(const PathBox& box);
  bool off_surface(const PathBox& box, int i);
  bool follow(PathBox& box, int at, int to);
  bool leave(int at, bool forward, geometry::IntervalVec3& w) const;
  bool chord_too_short(const PathBox& box, int i) const;
  bool on_wrong_side(int i) const;
  bool breaks_law(int i) const;
  void tangential(int i, const Vec3& c, Values& row) const;
  geometry::IntervalVec3 miss(int i) const;

  const std::vector<PathSurface>& surfaces_;
  const std::vector<int>& sides_;
  geometry::IntervalVec3 from_, to_;
  std::optional<Segment> beam_;  // the first segment, if it does not begin at a point
  double scale_;
  int n_;
  std::vector<double> index_;  // of the segment that ends at hop i
  // Of the box looked at.
  std::array<geometry::SurfaceEnclosure, kMaxHops> surface_;
  std::array<Segment, kMaxHops + 1> segments_;
};

}  // namespace caustic::solver
