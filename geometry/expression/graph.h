// Expressions as a directed graph in which no term stands twice, and their derivatives in it.
#pragma once

#include <cstdint>
#include <map>
#include <tuple>
#include <vector>

namespace caustic::geometry {

/// What a node computes from its operands a, b and its constant c. Differences, quotients and
/// negatives are written with these: a − b = a + (−1)·b, a/b = a·(1/b).
enum class Term : std::uint8_t {
  constant,    // c
  variable,    // the a-th input
  add,         // a + b
  offset,      // a + c
  multiply,    // a·b
  scale,       // c·a
  square,      // a²
  cube,        // a³
  reciprocal,  // 1/a
  power,       // a^c, c not an integer, a > 0 (a >= 0 for c > 0)
  sqrt,
  sin,
  cos,
  exp,
  log,
  abs,
  sign,  // derivative of abs: −1, 0, 1
  kink,  // derivative of sign: 0, but without bound on intervals that hold zero
};

class Graph {
 public:
  using Id = std::int32_t;
  struct Node {
    Term term;
    Id a = -1, b = -1;
    double c = 0.0;
  };

  /// Operands come before what is made of them: a walk by rising id is in the order of evaluation.
  const Node& operator[](Id id) const { return nodes_[static_cast<std::size_t>(id)]; }
  Id size() const { return static_cast<Id>(nodes_.size()); }

  /// Constructors simplify: constants are folded (to NaN where they are undefined, and so is all
  /// that is made of them), equal factors and terms collected, what exists already is returned.
  Id constant(double c);
  Id variable(int index);
  Id add(Id a, Id b);
  Id subtract(Id a, Id b) { return add(a, scale(-1.0, b)); }
  Id multiply(Id a, Id b);
  Id divide(Id a, Id b) { return multiply(a, apply(Term::reciprocal, b)); }
  Id scale(double c, Id a);
  Id offset(Id a, double c);
  Id square(Id a);
  /// a^n, by multiplications; a^p; a^b = exp(b log a) if b is no constant.
  Id integer_power(Id a, std::int64_t n);
  Id real_power(Id a, double p);
  Id power(Id a, Id b);
  /// reciprocal, sqrt, sin, cos, exp, log, abs, sign, kink.
  Id apply(Term function, Id a);

  bool is_constant(Id a) const { return (*this)[a].term == Term::constant; }
  bool is_constant(Id a, double c) const { return is_constant(a) && (*this)[a].c == c; }

  /// Derivative of f when each variable i moves with the speed seeds[i] (forward mode). Nodes that
  /// are no variable and whose variables have no seed stand still.
  Id derivative(Id f, const std::vector<Id>& seeds);
  /// ∂f/∂(variable i), i < count (reverse mode: the cost does not grow with `count`).
  std::vector<Id> gradient(Id f, int count);
  /// True for each node that one of the outputs is made of.
  std::vector<bool> needed_for(const std::vector<Id>& outputs) const;
  /// Total degree of f as a polynomial in the variables i < count; −1 if it is none.
  int degree(Id f, int count) const;

 private:
  struct Partial {
    Id operand, factor;
  };
  /// Derivatives of a node with respect to its operands.
  std::vector<Partial> partials(Id id);
  Id node(Term term, Id a = -1, Id b = -1, double c = 0.0);

  std::vector<Node> nodes_;
  std::map<std::tuple<Term, Id, Id, std::uint64_t>, Id> known_;
};

}  // namespace caustic::geometry
