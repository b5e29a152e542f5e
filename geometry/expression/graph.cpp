#include "geometry/expression/graph.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/expression/functions.h"

namespace caustic::geometry {

using Id = Graph::Id;

Id Graph::node(Term term, Id a, Id b, double c) {
  const auto key = std::make_tuple(term, a, b, std::bit_cast<std::uint64_t>(c));
  const auto [place, is_new] = known_.emplace(key, size());
  if (is_new) nodes_.push_back({term, a, b, c});
  return place->second;
}

Id Graph::constant(double c) {
  const bool sound = std::isfinite(c);
  return node(Term::constant, -1, -1, sound ? c + 0.0 : std::numeric_limits<double>::quiet_NaN());
}

Id Graph::variable(int index) { return node(Term::variable, index); }

Id Graph::offset(Id a, double c) {
  const Node n = (*this)[a];
  if (std::isnan(c)) return constant(c);
  if (c == 0.0) return a;
  if (n.term == Term::constant) return constant(n.c + c);
  if (n.term == Term::offset) return offset(n.a, n.c + c);
  return node(Term::offset, a, -1, c);
}

Id Graph::scale(double c, Id a) {
  const Node n = (*this)[a];
  if (n.term == Term::constant) return constant(c * n.c);
  if (std::isnan(c) || c == 0.0) return constant(c);
  if (c == 1.0) return a;
  if (n.term == Term::scale) return scale(c * n.c, n.a);
  return node(Term::scale, a, -1, c);
}

Id Graph::add(Id a, Id b) {
  if (is_constant(a)) std::swap(a, b);
  if (is_constant(b)) return offset(a, (*this)[b].c);
  const Node m = (*this)[a], n = (*this)[b];
  if (m.term == Term::offset) return offset(add(m.a, b), m.c);
  if (n.term == Term::offset) return offset(add(a, n.a), n.c);
  // k·p + l·q: one term if p = q, a common factor if k = l.
  const double k = m.term == Term::scale ? m.c : 1.0, l = n.term == Term::scale ? n.c : 1.0;
  const Id p = m.term == Term::scale ? m.a : a, q = n.term == Term::scale ? n.a : b;
  if (p == q) return scale(k + l, p);
  if (k == l && k != 1.0) return scale(k, add(p, q));
  return node(Term::add, std::min(a, b), std::max(a, b));
}

Id Graph::multiply(Id a, Id b) {
  if (is_constant(a)) std::swap(a, b);
  if (is_constant(b)) return scale((*this)[b].c, a);
  if (a == b) return square(a);
  const Node m = (*this)[a], n = (*this)[b];
  if (m.term == Term::scale) return scale(m.c, multiply(m.a, b));
  if (n.term == Term::scale) return scale(n.c, multiply(a, n.a));
  if (n.term == Term::square && n.a == a) return node(Term::cube, a);
  if (m.term == Term::square && m.a == b) return node(Term::cube, b);
  return node(Term::multiply, std::min(a, b), std::max(a, b));
}

Id Graph::square(Id a) {
  const Node n = (*this)[a];
  if (n.term == Term::constant) return constant(n.c * n.c);
  if (n.term == Term::scale) return scale(n.c * n.c, square(n.a));
  if (n.term == Term::abs) return square(n.a);
  return node(Term::square, a);
}

Id Graph::integer_power(Id a, std::int64_t n) {
  if (n < 0) return apply(Term::reciprocal, integer_power(a, -n));
  if (n == 0) return constant(1.0);
  if (n == 1) return a;
  if (n % 2 == 0) return square(integer_power(a, n / 2));
  return multiply(a, integer_power(a, n - 1));
}

Id Graph::real_power(Id a, double p) {
  const Node n = (*this)[a];
  if (n.term == Term::constant || std::isnan(p)) return constant(std::pow(n.c, p));
  if (p == std::round(p)) return integer_power(a, std::llround(p));
  if (p == 0.5) return apply(Term::sqrt, a);
  return node(Term::power, a, -1, p);
}

Id Graph::power(Id a, Id b) {
  if (is_constant(b)) return real_power(a, (*this)[b].c);
  return apply(Term::exp, multiply(b, apply(Term::log, a)));
}

Id Graph::apply(Term function, Id a) {
  const Node n = (*this)[a];
  if (n.term == Term::constant) return constant(apply_function(function, n.c, 0.0));
  if (function == Term::reciprocal && n.term == Term::scale) {
    return scale(1.0 / n.c, apply(function, n.a));
  }
  return node(function, a);
}

std::vector<Graph::Partial> Graph::partials(Id id) {
  const Node n = (*this)[id];
  const auto one = [&](Id factor) { return std::vector<Partial>{{n.a, factor}}; };
  switch (n.term) {
    case Term::constant:
    case Term::variable:
      return {};
    case Term::add:
      return {{n.a, constant(1.0)}, {n.b, constant(1.0)}};
    case Term::offset:
      return one(constant(1.0));
    case Term::multiply:
      return {{n.a, n.b}, {n.b, n.a}};
    case Term::scale:
      return one(constant(n.c));
    case Term::square:
      return one(scale(2.0, n.a));
    case Term::cube:
      return one(scale(3.0, square(n.a)));
    case Term::reciprocal:
      return one(scale(-1.0, square(id)));
    case Term::power:
      return one(scale(n.c, real_power(n.a, n.c - 1.0)));
    case Term::sqrt:
      return one(scale(0.5, apply(Term::reciprocal, id)));
    case Term::sin:
      return one(apply(Term::cos, n.a));
    case Term::cos:
      return one(scale(-1.0, apply(Term::sin, n.a)));
    case Term::exp:
      return one(id);
    case Term::log:
      return one(apply(Term::reciprocal, n.a));
    case Term::abs:
      return one(apply(Term::sign, n.a));
    case Term::sign:
    case Term::kink:
      return one(apply(Term::kink, n.a));
  }
  return {};
}

std::vector<bool> Graph::needed_for(const std::vector<Id>& outputs) const {
  std::vector<bool> needed(nodes_.size(), false);
  for (const Id f : outputs) needed[static_cast<std::size_t>(f)] = true;
  for (std::size_t id = nodes_.size(); id-- > 0;) {
    if (!needed[id]) continue;
    for (const Id operand : {nodes_[id].a, nodes_[id].b}) {
      if (operand >= 0 && nodes_[id].term != Term::variable) {
        needed[static_cast<std::size_t>(operand)] = true;
      }
    }
  }
  return needed;
}

Id Graph::derivative(Id f, const std::vector<Id>& seeds) {
  const Id zero = constant(0.0);
  const std::vector<bool> needed = needed_for({f});
  std::vector<Id> speed(static_cast<std::size_t>(f) + 1, zero);
  for (Id id = 0; id <= f; ++id) {
    if (!needed[static_cast<std::size_t>(id)]) continue;
    const Node n = (*this)[id];
    Id& sum = speed[static_cast<std::size_t>(id)];
    if (n.term == Term::variable) {
      if (static_cast<std::size_t>(n.a) < seeds.size()) sum = seeds[static_cast<std::size_t>(n.a)];
      continue;
    }
    // A node whose operands stand still has no derivative to look at.
    const auto still = [&](Id operand) {
      return operand < 0 || is_constant(speed[static_cast<std::size_t>(operand)], 0.0);
    };
    if (still(n.a) && still(n.b)) continue;
    for (const Partial& partial : partials(id)) {
      const Id operand = speed[static_cast<std::size_t>(partial.operand)];
      if (!is_constant(operand, 0.0)) sum = add(sum, multiply(partial.factor, operand));
    }
  }
  return speed[static_cast<std::size_t>(f)];
}

std::vector<Id> Graph::gradient(Id f, int count) {
  const Id zero = constant(0.0);
  std::vector<Id> adjoint(static_cast<std::size_t>(f) + 1, zero);
  std::vector<Id> out(static_cast<std::size_t>(count), zero);
  adjoint.back() = constant(1.0);
  for (Id id = f; id >= 0; --id) {
    const Id weight = adjoint[static_cast<std::size_t>(id)];
    if (is_constant(weight, 0.0)) continue;
    const Node n = (*this)[id];
    if (n.term == Term::variable && n.a < count) out[static_cast<std::size_t>(n.a)] = weight;
    for (const Partial& partial : partials(id)) {
      Id& sum = adjoint[static_cast<std::size_t>(partial.operand)];
      sum = add(sum, multiply(weight, partial.factor));
    }
  }
  return out;
}

int Graph::degree(Id f, int count) const {
  constexpr int kNone = -1, kMost = 1 << 20;
  std::vector<int> degrees(static_cast<std::size_t>(f) + 1, 0);
  for (Id id = 0; id <= f; ++id) {
    const Node& n = (*this)[id];
    const auto of = [&](Id operand) { return degrees[static_cast<std::size_t>(operand)]; };
    int& d = degrees[static_cast<std::size_t>(id)];
    const auto times = [&](int factor) { d = of(n.a) < 0 ? kNone : factor * of(n.a); };
    switch (n.term) {
      case Term::constant:
        break;
      case Term::variable:
        d = n.a < count ? 1 : 0;
        break;
      case Term::add:
        d = of(n.a) < 0 || of(n.b) < 0 ? kNone : std::max(of(n.a), of(n.b));
        break;
      case Term::multiply:
        d = of(n.a) < 0 || of(n.b) < 0 ? kNone : of(n.a) + of(n.b);
        break;
      case Term::offset:
      case Term::scale:
        times(1);
        break;
      case Term::square:
        times(2);
        break;
      case Term::cube:
        times(3);
        break;
      default:
        d = of(n.a) == 0 ? 0 : kNone;
    }
    if (d > kMost) d = kNone;
  }
  return degrees[static_cast<std::size_t>(f)];
}

}  // namespace caustic::geometry
