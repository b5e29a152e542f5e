// Expressions evaluated while they are read, on any number type: no graph, no program, no
// derivatives but differences. For expressions without faults.
#pragma once

#include <array>
#include <cctype>
#include <stdexcept>
#include <string>

namespace caustic::test {

template <class T>
class ExpressionOracle {
 public:
  explicit ExpressionOracle(const std::string& text) : text_(text) {
    std::erase_if(text_, [](unsigned char c) { return std::isspace(c) != 0; });
  }

  T operator()(const std::array<T, 3>& x) const {
    std::size_t at = 0;
    const T value = sum(at, x);
    if (at != text_.size()) throw std::runtime_error("oracle stops at " + text_.substr(at));
    return value;
  }
  /// ∂/∂x_i by a central difference of this step.
  T partial(const std::array<T, 3>& x, int i, const T& step) const {
    std::array<T, 3> hi = x, lo = x;
    hi[i] += step;
    lo[i] -= step;
    return ((*this)(hi) - (*this)(lo)) / (2 * step);
  }

 private:
  using X = std::array<T, 3>;
  char next(std::size_t at) const { return at < text_.size() ? text_[at] : '\0'; }

  T sum(std::size_t& at, const X& x) const {
    T value = product(at, x);
    while (next(at) == '+' || next(at) == '-') {
      const T sign = text_[at++] == '+' ? 1 : -1;
      value = value + sign * product(at, x);
    }
    return value;
  }
  T product(std::size_t& at, const X& x) const {
    T value = signed_power(at, x);
    while (next(at) == '*' || next(at) == '/') {
      const bool times = text_[at++] == '*';
      const T other = signed_power(at, x);
      value = times ? T(value * other) : T(value / other);
    }
    return value;
  }
  T signed_power(std::size_t& at, const X& x) const {
    if (next(at) == '-') return -signed_power(++at, x);
    if (next(at) == '+') return signed_power(++at, x);
    using std::pow;
    const T base = atom(at, x);
    if (next(at) != '^') return base;
    const T exponent = signed_power(++at, x);
    const int whole = static_cast<int>(exponent);
    if (exponent != whole) return pow(base, exponent);
    T value = 1;
    for (int i = 0; i < (whole < 0 ? -whole : whole); ++i) value = value * base;
    return whole < 0 ? T(1 / value) : value;
  }
  T atom(std::size_t& at, const X& x) const {
    using std::abs, std::acos, std::cos, std::exp, std::log, std::sin, std::sqrt;
    std::string word;
    while (std::isalpha(static_cast<unsigned char>(next(at)))) word += text_[at++];
    if (word == "x") return x[0];
    if (word == "y") return x[1];
    if (word == "z") return x[2];
    if (word == "pi") return T(3.14159265358979323846);  // the program's: a double
    if (word.empty() && next(at) != '(') {
      std::size_t length = 0;
      const double value = std::stod(text_.substr(at), &length);
      at += length;
      return T(value);
    }
    ++at;
    const T inner = sum(at, x);
    ++at;
    if (word == "sqrt") return sqrt(inner);
    if (word == "sin") return sin(inner);
    if (word == "cos") return cos(inner);
    if (word == "exp") return exp(inner);
    if (word == "log") return log(inner);
    if (word == "abs") return abs(inner);
    if (word.empty()) return inner;
    throw std::runtime_error("oracle does not know " + word);
  }

  std::string text_;
};

}  // namespace caustic::test
