// The part of a cell that light comes from: a polygon whose corners are evaluated.
#pragma once

#include <array>
#include <map>
#include <memory_resource>
#include <vector>

#include "solver/explore.h"

namespace caustic::solver {

class CellClipper {
 public:
  /// Corners that it makes are added to the samples of `e`.
  CellClipper(Exploration& e, Evaluator& evaluate, const Domain& domain)
      : e_(e), evaluate_(evaluate), domain_(domain) {}

  /// The part of a polygon inside the chart's own cell and the domain, as far as paths do not end;
  /// empty if there is none.
  std::vector<Corner> operator()(int chart, std::vector<Corner> polygon);

 private:
  Corner path_end(int chart, const Corner& a, const Corner& b);
  std::vector<Corner> clip_path_ends(int chart, const std::vector<Corner>& polygon);
  const geometry::Bound* bound(int boundary, int chart) const;
  double height(int boundary, int chart, const FieldPoint& f) const;
  Corner crossing(int boundary, int chart, const Corner& a, const Corner& b);
  void clip_at(int boundary, int chart, std::vector<Corner>& polygon);

  Exploration& e_;
  Evaluator& evaluate_;
  const Domain& domain_;
  std::pmr::monotonic_buffer_resource memory_;
  std::pmr::map<std::array<int, 3>, Corner> crossings_{&memory_};  // by both samples and boundary
};

}  // namespace caustic::solver
