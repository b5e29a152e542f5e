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

  /// Later hits are those next to the hits `near`, if given.
  FieldPoint operator()(const Point& x, const Hit* near = nullptr) {
    ++evaluations_;
    return map_.evaluate(x, near);
  }
  /// The surface point next to x, evaluated.
  FieldPoint on_surface(const Point& x, const Hit* near = nullptr) {
    return (*this)(map_.project(x), near);
  }

  const ForwardMap& map() const { return map_; }
  Budget& budget() { return budget_; }

 private:
  const ForwardMap& map_;
  Budget& budget_;
  std::uint64_t evaluations_ = 0;
};

}  // namespace caustic::solver
