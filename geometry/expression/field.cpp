#include "geometry/expression/field.h"

#include <algorithm>

#include "geometry/expression/parse.h"

namespace caustic::geometry {

namespace {

using Id = Graph::Id;

constexpr int kPointInputs = 3;  // x
constexpr int kAlongInputs = 6;  // x, u
constexpr int kThirdInputs = 9;  // x, u, v

std::vector<Id> variables(Graph& graph, int first) {
  return {graph.variable(first), graph.variable(first + 1), graph.variable(first + 2)};
}

}  // namespace

Expression read_expression(std::string_view text, double metres) {
  Expression e;
  std::array<Id, 3> xyz;
  for (int i = 0; i < 3; ++i) xyz[i] = e.graph.scale(1.0 / metres, e.graph.variable(i));
  const ParsedExpression parsed = parse_expression(text, xyz, e.graph);
  e.root = parsed.root;
  e.fault = parsed.fault;
  return e;
}

Field::Field(Expression expression, double factor) {
  Graph& graph = expression.graph;
  const Id g = graph.scale(factor, expression.root);
  degree_ = graph.degree(g, kPointInputs);

  const std::vector<Id> gradient = graph.gradient(g, kPointInputs);
  std::vector<Id> outputs{g};
  value_ = Program(graph, outputs, kPointInputs);
  outputs.insert(outputs.end(), gradient.begin(), gradient.end());
  first_ = Program(graph, outputs, kPointInputs);
  for (const auto& [i, j] : kPackedIndices) {
    std::vector<Id> axis(kPointInputs, graph.constant(0.0));
    axis[static_cast<std::size_t>(j)] = graph.constant(1.0);
    outputs.push_back(graph.derivative(gradient[static_cast<std::size_t>(i)], axis));
  }
  second_ = Program(graph, outputs, kPointInputs);
  for (std::size_t k = 0; k < 3; ++k) {
    constexpr std::size_t kDiagonal[3] = {4, 7, 9};
    axis_[k] = Program(graph, {g, outputs[1 + k], outputs[kDiagonal[k]]}, kPointInputs);
  }

  // Σ_jk g_ijk u_j v_k = ∂_i (uᵀ H v): twice forward, once in reverse.
  const std::vector<Id> u = variables(graph, 3), v = variables(graph, 6);
  const Id along_u = graph.derivative(g, u);
  const std::vector<Id> third = graph.gradient(graph.derivative(along_u, v), kPointInputs);
  third_ = Program(graph, third, kThirdInputs);
  std::vector<Id> thirds = graph.gradient(graph.derivative(along_u, u), kPointInputs);
  const std::vector<Id> vv =
      graph.gradient(graph.derivative(graph.derivative(g, v), v), kPointInputs);
  thirds.insert(thirds.end(), third.begin(), third.end());
  thirds.insert(thirds.end(), vv.begin(), vv.end());
  thirds_ = Program(graph, thirds, kThirdInputs);
  third_vanishes_ =
      std::all_of(third.begin(), third.end(), [&](Id id) { return graph.is_constant(id, 0.0); });

  std::vector<Id> orders{g}, taylor{g};
  double factorial = 1.0;
  for (int order = 1; order <= (quartic() ? 4 : 3); ++order) {
    orders.push_back(graph.derivative(orders.back(), u));
    factorial *= order;
    taylor.push_back(graph.scale(1.0 / factorial, orders.back()));
    if (order < 4) along_[order] = Program(graph, orders, kAlongInputs);
  }
  along_[0] = Program(graph, {g}, kAlongInputs);
  if (quartic()) taylor_ = Program(graph, taylor, kAlongInputs);
}

double Field::value(const Point& x) const {
  double g;
  value_.run(x.data(), &g);
  return g;
}

double Field::value_gradient(const Point& x, Vec3& gradient) const {
  double out[4];
  first_.run(x.data(), out);
  gradient = {out[1], out[2], out[3]};
  return out[0];
}

double Field::derivatives(const Point& x, Vec3& gradient, Mat3& hessian) const {
  double out[10];
  second_.run(x.data(), out);
  gradient = {out[1], out[2], out[3]};
  hessian << out[4], out[5], out[6], out[5], out[7], out[8], out[6], out[8], out[9];
  return out[0];
}

Vec3 Field::third_derivative(const Point& x, const Vec3& u, const Vec3& v) const {
  if (third_vanishes_) return Vec3::Zero();
  const double in[kThirdInputs] = {x[0], x[1], x[2], u[0], u[1], u[2], v[0], v[1], v[2]};
  Vec3 out;
  third_.run(in, out.data());
  return out;
}

std::array<Vec3, 3> Field::third_derivatives(const Point& x, const Vec3& u, const Vec3& v) const {
  const double in[kThirdInputs] = {x[0], x[1], x[2], u[0], u[1], u[2], v[0], v[1], v[2]};
  double out[9];
  thirds_.run(in, out);
  return {Vec3(out[0], out[1], out[2]), Vec3(out[3], out[4], out[5]), Vec3(out[6], out[7], out[8])};
}

std::array<double, 3> Field::along_axis(const Point& x, int k) const {
  std::array<double, 3> out;
  axis_[static_cast<std::size_t>(k)].run(x.data(), out.data());
  return out;
}

bool Field::enclose(const IntervalVec3& x, Interval& g) const { return value_.run(x.data(), &g); }

bool Field::enclose(const IntervalVec3& x, Interval& g, IntervalVec3& gradient) const {
  std::array<Interval, 4> out;
  const bool defined = first_.run(x.data(), out.data());
  g = out[0];
  std::copy_n(out.begin() + 1, 3, gradient.begin());
  return defined;
}

bool Field::enclose(const IntervalVec3& x, SurfaceEnclosure& e) const {
  std::array<Interval, 10> out;
  const bool defined = second_.run(x.data(), out.data());
  e.g = out[0];
  std::copy_n(out.begin() + 1, 3, e.gradient.begin());
  std::copy_n(out.begin() + 4, 6, e.hessian.begin());
  return defined;
}

// T(e₀, e₀), T(e₀, e₁), T(e₁, e₁) and T(e₂, e₂) have all ten components.
bool Field::enclose_third(const IntervalVec3& x, IntervalSym333& third) const {
  const Interval in[kThirdInputs] = {x[0], x[1], x[2], 1.0, 0.0, 0.0, 0.0, 1.0, 0.0};
  const Interval last[kThirdInputs] = {x[0], x[1], x[2], 0.0, 0.0, 1.0, 0.0, 0.0, 1.0};
  std::array<Interval, 9> of_first;
  IntervalVec3 of_last;
  const bool defined = thirds_.run(in, of_first.data());
  for (int a = 0; a < 3; ++a) {
    third[packed_index(a, 0, 0)] = of_first[static_cast<std::size_t>(a)];
    third[packed_index(a, 0, 1)] = of_first[static_cast<std::size_t>(3 + a)];
    third[packed_index(a, 1, 1)] = of_first[static_cast<std::size_t>(6 + a)];
  }
  const bool also = third_.run(last, of_last.data());
  for (int a = 0; a < 3; ++a) {
    third[packed_index(a, 2, 2)] = of_last[static_cast<std::size_t>(a)];
  }
  return defined && also;
}

Polynomial Field::polynomial(const Ray& ray) const {
  const Point& o = ray.origin;
  const Vec3& d = ray.direction;
  const double in[kAlongInputs] = {o[0], o[1], o[2], d[0], d[1], d[2]};
  Polynomial p;
  p.degree = degree_;
  taylor_.run(in, p.c.data());
  return p;
}

void Field::along(const Ray& ray, double t, int order, double* out) const {
  const Point x = ray.at(t);
  const Vec3& d = ray.direction;
  const double in[kAlongInputs] = {x[0], x[1], x[2], d[0], d[1], d[2]};
  along_[static_cast<std::size_t>(order)].run(in, out);
}

bool Field::along(const Ray& ray, const Interval& t, int order, Interval* out) const {
  const Point& o = ray.origin;
  const Vec3& d = ray.direction;
  const Interval in[kAlongInputs] = {
      o[0] + d[0] * t, o[1] + d[1] * t, o[2] + d[2] * t, d[0], d[1], d[2]};
  return along_[static_cast<std::size_t>(order)].run(in, out);
}

}  // namespace caustic::geometry
