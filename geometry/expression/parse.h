// Reads an expression in x, y and z:
//   sum      product { ("+" | "-") product }
//   product  unary { ("*" | "/") unary }
//   unary    { "+" | "-" } power
//   power    atom [ "^" unary ]            to the right: 2^3^2 = 2^9, and -x^2 = -(x^2)
//   atom     number | "x" | "y" | "z" | "pi" | "(" sum ")" | function "(" sum ")"
//   function "sqrt" | "sin" | "cos" | "exp" | "log" | "abs"
#pragma once

#include <array>
#include <string>
#include <string_view>

#include "geometry/expression/graph.h"

namespace caustic::geometry {

constexpr std::size_t kMaxExpressionLength = 4096;
/// Parentheses, signs and exponents inside of each other.
constexpr int kMaxExpressionDepth = 64;
/// Whole exponents are made of multiplications.
constexpr double kMaxExponent = 1000.0;

struct ParsedExpression {
  Graph::Id root = -1;
  std::string fault;  ///< what is wrong and at which column (1 is the first); empty if nothing is
};

/// Adds the expression to `graph`; x, y and z stand for the given nodes.
ParsedExpression parse_expression(std::string_view text, const std::array<Graph::Id, 3>& xyz,
                                  Graph& graph);

}  // namespace caustic::geometry
