#include "geometry/expression/program.h"

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <memory>
#include <type_traits>

namespace caustic::geometry {

namespace {

using Id = Graph::Id;
using Kind = Step::Kind;

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
/// Programs with no more registers run in a fixed array.
constexpr std::size_t kFewRegisters = 192;

double squared(double a) { return a * a; }
Interval squared(const Interval& a) { return sqr(a); }
double cubed(double a) { return a * a * a; }
Interval cubed(const Interval& a) { return power(a, 3); }

/// Chooses steps for the nodes that outputs need. What only one other node uses can become a part
/// of that one's step.
class Compiler {
 public:
  Compiler(const Graph& graph, const std::vector<Id>& outputs, int inputs)
      : graph_(graph),
        registers_(static_cast<std::size_t>(graph.size()), kNone),
        uses_(static_cast<std::size_t>(graph.size()), 0),
        parts_(static_cast<std::size_t>(graph.size()), kNoPart),
        next_(static_cast<std::uint32_t>(inputs)) {
    const std::vector<bool> needed = graph.needed_for(outputs);
    const auto for_needed = [&](Id id, const auto& action) {
      if (needed[static_cast<std::size_t>(id)]) action(id);
    };
    for (Id id = 0; id < graph.size(); ++id) for_needed(id, [&](Id i) { count_uses(i); });
    for (const Id output : outputs) uses_[static_cast<std::size_t>(output)] += 2;
    // From the outputs down: a part has no parts.
    for (Id id = graph.size(); id-- > 0;) for_needed(id, [&](Id i) { choose_part(i); });
    for (Id id = 0; id < graph.size(); ++id) for_needed(id, [&](Id i) { emit(i); });
  }

  std::vector<Step> steps;
  std::uint32_t register_of(Id id) const {
    return id < 0 ? 0U : registers_[static_cast<std::size_t>(id)];
  }

 private:
  static constexpr Id kNoPart = -1, kIsPart = -2;
  Id& part_of(Id id) { return parts_[static_cast<std::size_t>(id)]; }

  void count_uses(Id id) {
    if (graph_[id].term == Term::variable) return;
    for (const Id operand : {graph_[id].a, graph_[id].b}) {
      if (operand >= 0) ++uses_[static_cast<std::size_t>(operand)];
    }
  }

  void choose_part(Id id) {
    const Graph::Node& n = graph_[id];
    if (part_of(id) == kIsPart) return;
    const auto take = [&](Id operand, std::initializer_list<Term> terms) {
      if (part_of(id) >= 0 || uses_[static_cast<std::size_t>(operand)] != 1) return;
      if (std::find(terms.begin(), terms.end(), graph_[operand].term) == terms.end()) return;
      part_of(id) = operand;
      part_of(operand) = kIsPart;
    };
    if (n.term == Term::offset) take(n.a, {Term::scale});
    if (n.term == Term::scale) take(n.a, {Term::multiply, Term::offset});
    if (n.term != Term::add) return;
    take(n.b, {Term::multiply, Term::square, Term::scale});
    take(n.a, {Term::multiply, Term::square, Term::scale});
  }

  void emit(Id id) {
    const Graph::Node& n = graph_[id];
    if (n.term == Term::constant || part_of(id) == kIsPart) return;
    std::uint32_t& place = registers_[static_cast<std::size_t>(id)];
    if (n.term == Term::variable) {
      place = static_cast<std::uint32_t>(n.a);
      return;
    }
    steps.push_back(part_of(id) >= 0 ? step_with(part_of(id), n) : step(n));
    place = next_++;
  }

  Step step(const Graph::Node& n) const {
    const std::uint32_t a = register_of(n.a), b = register_of(n.b);
    switch (n.term) {
      case Term::add:
        return {Kind::add, n.term, a, b};
      case Term::offset:
        return {Kind::affine, n.term, a, 0, 0, 1.0, n.c};
      case Term::multiply:
        return {Kind::multiply, n.term, a, b};
      case Term::scale:
        return {Kind::scale, n.term, a, 0, 0, n.c};
      case Term::square:
        return {Kind::square, n.term, a};
      case Term::cube:
        return {Kind::cube, n.term, a};
      default:
        return {Kind::function, n.term, a, 0, 0, n.c};
    }
  }

  Step step_with(Id part, const Graph::Node& n) const {
    const Graph::Node& p = graph_[part];
    const std::uint32_t a = register_of(p.a), b = register_of(p.b);
    if (n.term == Term::offset) return {Kind::affine, n.term, a, 0, 0, p.c, n.c};
    if (n.term == Term::scale && p.term == Term::multiply) {
      return {Kind::scale_multiply, n.term, a, b, 0, n.c};
    }
    if (n.term == Term::scale) return {Kind::affine, n.term, a, 0, 0, n.c, n.c * p.c};
    const std::uint32_t other = register_of(part == n.a ? n.b : n.a);
    if (p.term == Term::square) return {Kind::square_add, n.term, a, 0, other};
    if (p.term == Term::multiply) return {Kind::multiply_add, n.term, a, b, other};
    if (p.c == -1.0) return {Kind::subtract, n.term, other, a};
    return {Kind::scale_add, n.term, a, 0, other, p.c};
  }

  const Graph& graph_;
  std::vector<std::uint32_t> registers_;
  std::vector<int> uses_;
  std::vector<Id> parts_;
  std::uint32_t next_;
};

}  // namespace

Program::Program(const Graph& graph, const std::vector<Id>& outputs, int inputs)
    : inputs_(static_cast<std::size_t>(inputs)) {
  Compiler compiler(graph, outputs, inputs);
  steps_ = std::move(compiler.steps);
  for (const Id output : outputs) {
    const bool constant = graph.is_constant(output);
    outputs_.push_back({constant ? kNone : compiler.register_of(output), graph[output].c});
  }
}

template <class T>
bool Program::execute(const T* inputs, T* outputs) const {
  std::array<T, kFewRegisters> few;
  std::unique_ptr<T[]> many;
  T* r = few.data();
  if (inputs_ + steps_.size() > few.size()) {
    many = std::make_unique<T[]>(inputs_ + steps_.size());
    r = many.get();
  }
  std::copy_n(inputs, inputs_, r);
  bool defined = true;
  T* result = r + inputs_;
  for (const Step& s : steps_) {
    const T& a = r[s.a];
    switch (s.kind) {
      case Kind::add:
        *result = a + r[s.b];
        break;
      case Kind::subtract:
        *result = a - r[s.b];
        break;
      case Kind::multiply:
        *result = a * r[s.b];
        break;
      case Kind::multiply_add:
        *result = a * r[s.b] + r[s.d];
        break;
      case Kind::scale_multiply:
        *result = s.c * (a * r[s.b]);
        break;
      case Kind::square:
        *result = squared(a);
        break;
      case Kind::square_add:
        *result = squared(a) + r[s.d];
        break;
      case Kind::cube:
        *result = cubed(a);
        break;
      case Kind::scale:
        *result = s.c * a;
        break;
      case Kind::scale_add:
        *result = s.c * a + r[s.d];
        break;
      case Kind::affine:
        *result = s.c * a + s.k;
        break;
      case Kind::function:
        if constexpr (std::is_same_v<T, Interval>) defined &= defined_on(s.function, a, s.c);
        *result = apply_function(s.function, a, s.c);
        break;
    }
    ++result;
  }
  for (const Output& output : outputs_) {
    *outputs++ = output.register_index == kNone ? T(output.constant) : r[output.register_index];
  }
  return defined;
}

void Program::run(const double* inputs, double* outputs) const { execute(inputs, outputs); }
bool Program::run(const Interval* inputs, Interval* outputs) const {
  return execute(inputs, outputs);
}

}  // namespace caustic::geometry
