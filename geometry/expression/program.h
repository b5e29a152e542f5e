// Straight-line programs: what a graph computes, as a flat list of operations on registers, run on
// numbers and on intervals.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "geometry/expression/functions.h"
#include "geometry/expression/graph.h"

namespace caustic::geometry {

/// The result of a step goes into the register after the previous one's.
struct Step {
  /// Sums with a product are one step each: an interpreter pays by the step.
  enum class Kind : std::uint8_t {
    add,             // a + b
    subtract,        // a − b
    multiply,        // a·b
    multiply_add,    // a·b + d
    scale_multiply,  // c·a·b
    square,          // a²
    square_add,      // a² + d
    cube,            // a³
    scale,           // c·a
    scale_add,       // c·a + d
    affine,          // c·a + k
    function,        // function(a), with the constant c
  };
  Kind kind;
  Term function = Term::constant;
  std::uint32_t a = 0, b = 0, d = 0;
  double c = 0.0, k = 0.0;
};

class Program {
 public:
  Program() = default;
  /// Computes `outputs` from `inputs` variables; what they do not need is left out.
  Program(const Graph& graph, const std::vector<Graph::Id>& outputs, int inputs);

  std::size_t steps() const { return steps_.size(); }

  /// NaN where it is undefined.
  void run(const double* inputs, double* outputs) const;
  /// False if some step is undefined on a part of its argument.
  bool run(const Interval* inputs, Interval* outputs) const;

 private:
  /// The constant, or the register if that is not none.
  struct Output {
    std::uint32_t register_index;
    double constant;
  };

  template <class T>
  bool execute(const T* inputs, T* outputs) const;

  std::size_t inputs_ = 0;
  std::vector<Step> steps_;
  std::vector<Output> outputs_;
};

}  // namespace caustic::geometry
