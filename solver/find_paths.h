// All specular paths of a family between a light and a point: found, judged against apertures and
// visibility, and sharpened.
#pragma once

#include <optional>
#include <vector>

#include "solver/path_search.h"

namespace caustic::solver {

/// Surface indices in the order of the light.
using Family = std::vector<int>;

struct FamilyPath {
  SpecularChain chain;
  SpecularPath path;  ///< `from` is the light's position, or for a beam a point of its ray
};

/// One family and one light; asked for one point after the other.
class PathFinder {
 public:
  /// The system must outlive it. Its own light is not looked at.
  PathFinder(const OpticalSystem& system, Family family, const Light& light);

  struct Answer {
    std::vector<FamilyPath> paths;  ///< in the order of the first hit's coordinates
    std::size_t undecided = 0;      ///< cells about a caustic through p, or a perfect focus
  };
  Answer to(const Point& p);
  /// The path over these points, which obey the law of every hop, if apertures and visibility let
  /// it through.
  std::optional<FamilyPath> admit(const std::vector<Point>& hits, const Point& p) const;
  const PencilTracer& tracer() const { return search_.tracer(); }

 private:
  bool exists(const std::vector<Point>& hits) const;
  bool visible(const Point& from, const std::vector<Point>& hits, const Point& p) const;
  Point source_of(const Point& first_hit) const;

  const OpticalSystem& system_;
  Family family_;
  PathSearch search_;
};

/// By the coordinates of the first hit.
void sort_paths(std::vector<FamilyPath>& paths);

/// True if a surface of the system stands between a and b. `from` and `to` are the surfaces on
/// which the ends lie (−1: none); their crossings there are not in the way.
bool segment_hidden(const OpticalSystem& system, const Point& a, int from, const Point& b, int to);

}  // namespace caustic::solver
