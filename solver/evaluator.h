// A forward map that counts what is asked of it. One per task, so that nothing is shared.
#pragma once

#include "solver/budget.h"
#include "solver/forward_map.h"

namespace caustic::solver {

class Evaluator {
 public:
  Evaluator(const ForwardMap& map, Budget& budget) : map_(map), budget_(budget) {}
  ~Evaluator() { budget_.count_evaluations(evaluations_); }
  Evaluator(const Evaluator&) = delete;
  Evaluator& operator=(const Evaluator&) = delete;

  FieldPoint operator()(const Point& x) {
    ++evaluations_;
    return map_.evaluate(x);
  }
  /// The surface point next to x, evaluated.
  FieldPoint on_surface(const Point& x) { return (*this)(map_.project(x)); }

  const ForwardMap& map() const { return map_; }
  Budget& budget() { return budget_; }

 private:
  const ForwardMap& map_;
  Budget& budget_;
  std::uint64_t evaluations_ = 0;
};

}  // namespace caustic::solver
