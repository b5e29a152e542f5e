// All rays of a family that pass through a point: point location in the image of a subdivision of
// the first surface, then Newton's method. The subdivision is refined where a question needs it and
// kept for the next one. NOTATION.md (S36), (S37).
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "geometry/chart.h"
#include "solver/chart_place.h"
#include "solver/location_tree.h"
#include "solver/pencil.h"
#include "solver/seek.h"

namespace caustic::solver {

class PathSearch {
 public:
  /// `extent` is what of the first surface is searched; `lit_side` = ±1 if light is known to come
  /// to it from there, 0 if it may come from either side.
  PathSearch(PencilTracer tracer, const geometry::Extent& extent, int lit_side = 0);

  const PencilTracer& tracer() const { return tracer_; }

  struct Answer {
    std::vector<Pencil> pencils;  ///< each meets p; apertures and visibility are not looked at
    /// First hits in cells that were given up: about a caustic through p, or a perfect focus.
    std::vector<Point> undecided;
  };
  /// Not thread-safe: the subdivision grows.
  Answer through(const Point& p);
  std::size_t cells() const { return cells_.size(); }

 private:
  using Vec2 = geometry::Vec2;
  using Nine = std::array<int, 9>;  // samples of a cell, 3 × 3, s fastest
  // A ray in the frame (u, v, w) of a cell: it meets the plane w·(x − o) = τ at `at` + τ `slope`.
  struct LocalRay {
    Vec2 at = Vec2::Zero(), slope = Vec2::Zero();
  };
  enum class Kind : std::uint8_t { dead, broken, wide, smooth };
  struct Cell {
    int chart, depth;
    std::int64_t i, j;   // lower corner on the grid
    int sought = 0;      // levels of the depth that were divided to find something small …
    bool seeks = false;  // … as the next one is
    Kind kind = Kind::dead;
    int children = -1;  // first of four
    Direction u, v, w;
    Point o;
    std::array<LocalRay, 9> rays;             // 3 × 3, s fastest
    double reach_o = 0.0, reach_w = 0.0;      // spread of places and directions across w, inflated
    double bending_o = 0.0, bending_w = 0.0;  // largest second differences of rays
    double behind = 0.0;                      // how far before o a ray of the cell may start
    int level() const { return depth - sought; }
  };
  struct Sample {
    Point x;
    Pencil ray;
    bool valid;
    bool lit;  ///< the light comes from the side that it can come from
  };
  struct Bending;
  struct Locus;  // a cell's image in the plane through p across its middle ray

  static std::int64_t half_side(const Cell& cell) {
    return std::int64_t{1} << (kChartDepth - cell.depth - 1);
  }
  double grid_unit() const { return 1.0 / (base_ * double(std::int64_t{1} << kChartDepth)); }
  int sample(int chart, std::int64_t i, std::int64_t j);
  void make(Cell& cell);
  void set_rays(Cell& cell, const Nine& samples) const;
  void spread_by_derivatives(Cell& cell, const Nine& samples, double radius) const;
  int lit_from(const Point& x) const;
  double apparent_size(const Point& middle, double radius) const;
  Between between_rays(const Nine& samples) const;
  bool jumps(const Nine& samples) const;
  int split(int cell);
  bool may_pass(const Cell& cell, const Point& p, double radius, Locus& locus) const;
  std::vector<int> narrowed(const std::vector<int>& cells, const Point& p, double radius) const;
  void refine(const Point& start, const Point& p, Answer& answer) const;
  void refine_from_samples(const Cell& cell, const Point& p, Answer& answer);
  Point place(const Cell& cell, double s, double t) const;

  PencilTracer tracer_;
  std::vector<geometry::Chart> charts_;
  double scale_;
  int base_, lit_side_;
  std::vector<Cell> cells_;
  std::vector<Sample> samples_;
  std::unordered_map<ChartPlace, int, ChartPlaceHash> known_;
  std::vector<int> stack_;
  LocationTree places_;
};

}  // namespace caustic::solver
