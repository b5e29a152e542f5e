#include "geometry/expression/parse.h"

#include <charconv>
#include <cmath>
#include <utility>

#include "geometry/linear.h"

namespace caustic::geometry {

namespace {

using Id = Graph::Id;

constexpr std::pair<std::string_view, Term> kFunctions[] = {
    {"sqrt", Term::sqrt}, {"sin", Term::sin}, {"cos", Term::cos},
    {"exp", Term::exp},   {"log", Term::log}, {"abs", Term::abs}};

// Locales do not matter here.
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

/// By recursive descent. After a fault everything returns at once; the first fault is kept.
class Parser {
 public:
  Parser(std::string_view text, const std::array<Id, 3>& xyz, Graph& graph)
      : text_(text), xyz_(xyz), graph_(graph) {}

  ParsedExpression parse() {
    if (text_.size() > kMaxExpressionLength) {
      fail("longer than " + std::to_string(kMaxExpressionLength) + " characters",
           kMaxExpressionLength);
      return {-1, fault_};
    }
    const Id root = sum();
    skip_blanks();
    if (sound() && at_ < text_.size()) fail("unexpected " + quoted_next(), at_);
    return {sound() ? root : -1, fault_};
  }

 private:
  Id sum() {
    Id left = product();
    while (sound()) {
      if (take('+'))
        left = graph_.add(left, product());
      else if (take('-'))
        left = graph_.subtract(left, product());
      else
        break;
    }
    return left;
  }

  Id product() {
    Id left = unary();
    while (sound()) {
      if (take('*'))
        left = graph_.multiply(left, unary());
      else if (take('/'))
        left = graph_.divide(left, unary());
      else
        break;
    }
    return left;
  }

  Id unary() {
    const Deeper deeper(*this);
    if (!sound()) return nothing();
    if (take('-')) return graph_.scale(-1.0, unary());
    if (take('+')) return unary();
    return power();
  }

  Id power() {
    const Id base = atom();
    skip_blanks();
    const std::size_t place = at_;
    if (!sound() || !take('^')) return base;
    const Id exponent = unary();
    if (!sound()) return nothing();
    if (graph_.is_constant(exponent) && std::abs(graph_[exponent].c) > kMaxExponent) {
      fail("exponent beyond " + std::to_string(static_cast<int>(kMaxExponent)), place);
      return nothing();
    }
    return graph_.power(base, exponent);
  }

  Id atom() {
    skip_blanks();
    if (at_ == text_.size()) return fail("unexpected end", at_);
    const char c = text_[at_];
    if (is_digit(c) || c == '.') return number();
    if (is_letter(c)) return name();
    const std::size_t open = at_;
    if (!take('(')) return fail("unexpected " + quoted_next(), at_);
    return closed(open);
  }

  // What follows "(" up to its ")".
  Id closed(std::size_t open) {
    const Id inner = sum();
    if (!sound() || take(')')) return inner;
    if (at_ < text_.size()) return fail("unexpected " + quoted_next(), at_);
    return fail("\"(\" is never closed", open);
  }

  Id number() {
    double value = 0.0;
    const auto [end, error] =
        std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (error == std::errc::result_out_of_range) return fail("number out of range", at_);
    if (error != std::errc()) return fail("unexpected " + quoted_next(), at_);
    at_ = static_cast<std::size_t>(end - text_.data());
    return graph_.constant(value);
  }

  Id name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (is_letter(text_[at_]) || is_digit(text_[at_]))) ++at_;
    const std::string_view word = text_.substr(begin, at_ - begin);
    if (word == "x") return xyz_[0];
    if (word == "y") return xyz_[1];
    if (word == "z") return xyz_[2];
    if (word == "pi") return graph_.constant(kPi);
    for (const auto& [function, term] : kFunctions) {
      if (word != function) continue;
      skip_blanks();
      const std::size_t open = at_;
      if (!take('(')) return fail("\"" + std::string(word) + "\" needs \"(\"", at_);
      const Id argument = closed(open);
      return sound() ? graph_.apply(term, argument) : nothing();
    }
    skip_blanks();
    const bool called = at_ < text_.size() && text_[at_] == '(';
    return fail((called ? "unknown function \"" : "unknown name \"") +
                    std::string(word.substr(0, 40)) + "\" (" +
                    (called ? "sqrt, sin, cos, exp, log, abs" : "x, y, z, pi") + ")",
                begin);
  }

  void skip_blanks() {
    while (at_ < text_.size() &&
           (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\n' || text_[at_] == '\r')) {
      ++at_;
    }
  }
  bool take(char c) {
    skip_blanks();
    if (!sound() || at_ == text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }

  // A character as it may stand in a message: what is not printable ASCII is called so.
  std::string quoted_next() const {
    const char c = text_[at_];
    return c > ' ' && c <= '~' ? std::string("\"") + c + '"' : std::string("character");
  }

  bool sound() const { return fault_.empty(); }
  Id nothing() { return graph_.constant(0.0); }
  Id fail(const std::string& what, std::size_t place) {
    if (sound()) fault_ = what + " at column " + std::to_string(place + 1);
    return nothing();
  }

  /// Counts how deep the descent is; every way down passes through unary().
  struct Deeper {
    explicit Deeper(Parser& p) : parser(p) {
      if (++parser.depth_ > kMaxExpressionDepth) {
        parser.fail("nested deeper than " + std::to_string(kMaxExpressionDepth), parser.at_);
      }
    }
    ~Deeper() { --parser.depth_; }
    Parser& parser;
  };

  std::string_view text_;
  std::array<Id, 3> xyz_;
  Graph& graph_;
  std::size_t at_ = 0;
  int depth_ = 0;
  std::string fault_;
};

}  // namespace

ParsedExpression parse_expression(std::string_view text, const std::array<Id, 3>& xyz,
                                  Graph& graph) {
  return Parser(text, xyz, graph).parse();
}

}  // namespace caustic::geometry
