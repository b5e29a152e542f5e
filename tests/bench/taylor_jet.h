// Third-order jets in x, y and z, and a graph run on them: g, ∇g, H and all third derivatives at
// once, the alternative to differentiating an expression once and compiling that.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "geometry/expression/field.h"
#include "geometry/surface.h"

namespace caustic::bench {

using geometry::Point;
using geometry::Vec3;

/// Taylor coefficients of x^i y^j z^k, i + j + k <= 3, by rising degree.
struct TaylorJet {
  static constexpr int kCount = 20, kProducts = 84;
  struct Exponents {
    int i, j, k;
  };
  static constexpr std::array<Exponents, kCount> exponents() {
    std::array<Exponents, kCount> e{};
    int n = 0;
    for (int degree = 0; degree <= 3; ++degree) {
      for (int i = degree; i >= 0; --i) {
        for (int j = degree - i; j >= 0; --j) e[n++] = {i, j, degree - i - j};
      }
    }
    return e;
  }
  static constexpr int index(int i, int j, int k) {
    const auto e = exponents();
    for (int n = 0; n < kCount; ++n) {
      if (e[n].i == i && e[n].j == j && e[n].k == k) return n;
    }
    return -1;
  }
  struct Product {
    int a, b, to;
  };
  static constexpr std::array<Product, kProducts> products() {
    std::array<Product, kProducts> out{};
    const auto e = exponents();
    int n = 0;
    for (int a = 0; a < kCount; ++a) {
      for (int b = 0; b < kCount; ++b) {
        const int to = index(e[a].i + e[b].i, e[a].j + e[b].j, e[a].k + e[b].k);
        if (to >= 0) out[n++] = {a, b, to};
      }
    }
    return out;
  }

  std::array<double, kCount> c{};

  friend TaylorJet operator+(const TaylorJet& a, const TaylorJet& b) {
    TaylorJet r;
    for (int n = 0; n < kCount; ++n) r.c[n] = a.c[n] + b.c[n];
    return r;
  }
  friend TaylorJet operator*(double s, const TaylorJet& a) {
    TaylorJet r;
    for (int n = 0; n < kCount; ++n) r.c[n] = s * a.c[n];
    return r;
  }
  friend TaylorJet operator*(const TaylorJet& a, const TaylorJet& b) {
    static constexpr auto kTable = products();
    TaylorJet r;
#pragma GCC unroll 84
    for (int n = 0; n < kProducts; ++n) r.c[kTable[n].to] += a.c[kTable[n].a] * b.c[kTable[n].b];
    return r;
  }
  /// f(a), f given by its value and three derivatives at a's value.
  friend TaylorJet composed(const TaylorJet& a, const std::array<double, 4>& f) {
    TaylorJet d = a;
    d.c[0] = 0.0;
    const TaylorJet dd = d * d;
    TaylorJet r = f[1] * d + 0.5 * f[2] * dd + f[3] / 6.0 * (dd * d);
    r.c[0] = f[0];
    return r;
  }
};

/// Runs an expression as it was read.
class JetInterpreter {
 public:
  explicit JetInterpreter(const geometry::Expression& e)
      : graph_(e.graph),
        root_(e.root),
        needed_(e.graph.needed_for({e.root})),
        registers_(static_cast<std::size_t>(e.graph.size())) {}

  const TaylorJet& run(const Point& x) {
    for (geometry::Graph::Id id = 0; id <= root_; ++id) {
      if (needed_[static_cast<std::size_t>(id)]) at(id) = step(graph_[id], x);
    }
    return at(root_);
  }

 private:
  using Term = geometry::Term;
  TaylorJet& at(geometry::Graph::Id id) { return registers_[static_cast<std::size_t>(id)]; }

  TaylorJet step(const geometry::Graph::Node& n, const Point& x) {
    TaylorJet r;
    switch (n.term) {
      case Term::constant:
        r.c[0] = n.c;
        return r;
      case Term::variable:
        r.c[0] = x[n.a];
        r.c[static_cast<std::size_t>(1 + n.a)] = 1.0;
        return r;
      case Term::add:
        return at(n.a) + at(n.b);
      case Term::offset:
        r = at(n.a);
        r.c[0] += n.c;
        return r;
      case Term::multiply:
        return at(n.a) * at(n.b);
      case Term::scale:
        return n.c * at(n.a);
      case Term::square:
        return at(n.a) * at(n.a);
      case Term::cube:
        return at(n.a) * at(n.a) * at(n.a);
      default:
        return composed(at(n.a), derivatives(n.term, at(n.a).c[0], n.c));
    }
  }

  static std::array<double, 4> derivatives(Term function, double v, double p) {
    switch (function) {
      case Term::reciprocal:
        return {1 / v, -1 / (v * v), 2 / (v * v * v), -6 / (v * v * v * v)};
      case Term::sqrt:
        p = 0.5;
        [[fallthrough]];
      case Term::power: {
        const double f = std::pow(v, p);
        return {f, p * f / v, p * (p - 1) * f / (v * v), p * (p - 1) * (p - 2) * f / (v * v * v)};
      }
      case Term::sin:
        return {std::sin(v), std::cos(v), -std::sin(v), -std::cos(v)};
      case Term::cos:
        return {std::cos(v), -std::sin(v), -std::cos(v), std::sin(v)};
      case Term::exp:
        return {std::exp(v), std::exp(v), std::exp(v), std::exp(v)};
      case Term::log:
        return {std::log(v), 1 / v, -1 / (v * v), 2 / (v * v * v)};
      case Term::abs:
        return {std::abs(v), std::copysign(1.0, v), 0.0, 0.0};
      default:
        return {std::numeric_limits<double>::quiet_NaN()};
    }
  }

  const geometry::Graph graph_;
  geometry::Graph::Id root_;
  std::vector<bool> needed_;
  std::vector<TaylorJet> registers_;
};

/// All that tracing needs, from a jet.
struct JetDerivatives {
  geometry::SurfaceDerivatives d;
  geometry::ThirdDerivatives third;
};
inline JetDerivatives derivatives_of(const TaylorJet& jet, const Vec3& u, const Vec3& v) {
  const auto& c = jet.c;
  JetDerivatives r;
  r.d.g = c[0];
  r.d.gradient = {c[1], c[2], c[3]};
  r.d.hessian << 2.0 * c[4], c[5], c[6], c[5], 2.0 * c[7], c[8], c[6], c[8], 2.0 * c[9];
  // Layers ∂H/∂x, ∂H/∂y, ∂H/∂z of the third derivative.
  const double xxx = 6.0 * c[10], xxy = 2.0 * c[11], xxz = 2.0 * c[12], xyy = 2.0 * c[13],
               xyz = c[14], xzz = 2.0 * c[15], yyy = 6.0 * c[16], yyz = 2.0 * c[17],
               yzz = 2.0 * c[18], zzz = 6.0 * c[19];
  geometry::Mat3 X, Y, Z;
  X << xxx, xxy, xxz, xxy, xyy, xyz, xxz, xyz, xzz;
  Y << xxy, xyy, xyz, xyy, yyy, yyz, xyz, yyz, yzz;
  Z << xxz, xyz, xzz, xyz, yyz, yzz, xzz, yzz, zzz;
  const auto along = [&](const Vec3& a, const Vec3& b) -> Vec3 {
    return {a.dot(X * b), a.dot(Y * b), a.dot(Z * b)};
  };
  r.third = {along(u, u), along(u, v), along(v, v)};
  return r;
}

}  // namespace caustic::bench
