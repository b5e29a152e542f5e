#include "solver/path_derivatives.h"

#include <Eigen/LU>
#include <cmath>

namespace caustic::solver {

namespace {

using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 4 * kMaxHops, 3>;

// The change of every unknown with one coordinate of p: columns of z_p, the ends included.
struct Motion {
  const Columns& z_p;
  Eigen::Index hops;

  Vec3 vertex(Eigen::Index i, int b) const {
    if (i == 0) return Vec3::Zero();
    if (i > hops) return Vec3::Unit(b);
    return z_p.block<3, 1>(4 * (i - 1), b);
  }
  Vec3 segment(Eigen::Index k, int b) const { return vertex(k + 1, b) - vertex(k, b); }
  double multiplier(Eigen::Index i, int b) const { return z_p(4 * i + 3, b); }
};

// Second derivative of the unit vector v/|v| along δ and ε.
Vec3 bend(const Vec3& v, const Vec3& delta, const Vec3& epsilon) {
  const double inverse = 1.0 / v.norm();
  const Vec3 w = v * inverse;
  const double wd = w.dot(delta), we = w.dot(epsilon);
  const Vec3 Pd = delta - wd * w, Pe = epsilon - we * w;
  return -inverse * inverse * (we * Pd + wd * Pe + Pd.dot(Pe) * w);
}

// F differentiated along (z_b, p_b) and (z_c, p_c) with its own second derivative only (S33).
PathVector second_residual(const SpecularChain& chain, const SpecularPath& path,
                           const Motion& motion, int b, int c) {
  const auto n = motion.hops;
  PathVector r = PathVector::Zero(4 * n);
  for (Eigen::Index k = 0; k <= n; ++k) {
    const Vec3 turn =
        index_along(chain, k) * bend(path.segment(k), motion.segment(k, b), motion.segment(k, c));
    if (k > 0) r.segment<3>(4 * (k - 1)) -= turn;
    if (k < n) r.segment<3>(4 * k) += turn;
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& shape = *chain[i].shape;
    const Mat3 H = shape.derivatives(path.x[i]).hessian;
    const Vec3 xb = motion.vertex(i + 1, b), xc = motion.vertex(i + 1, c);
    const Vec3 Hb = H * xb, Hc = H * xc;
    r.segment<3>(4 * i) += path.lambda[i] * shape.third_derivative(path.x[i], xb, xc) +
                           motion.multiplier(i, b) * Hc + motion.multiplier(i, c) * Hb;
    r[4 * i + 3] += xb.dot(Hc);
  }
  return r;
}

// (S34). Factors are taken in pairs so that neither long paths nor units overflow.
double cross_section(const SpecularChain& chain, const SpecularPath& path, double det_A) {
  const double n0 = index_along(chain, 0);
  double D = n0 * n0 * det_A;
  for (std::size_t k = 0; k <= path.hops(); ++k) {
    const double ratio = path.segment(k).norm() / index_along(chain, k);
    D *= ratio * ratio;
    if (k == path.hops()) break;
    Vec3 N;
    chain[k].shape->value_gradient(path.x[k], N);
    const double in = N.dot(path.segment(k).normalized());
    const double out = N.dot(path.segment(k + 1).normalized());
    D /= -std::abs(in * out);  // |∇g|² cancels; (−1)^N of the bordered determinant
  }
  return D;
}

std::vector<Point> predicted(const SpecularPath& path, const PathDerivatives& d, const Vec3& shift,
                             bool second) {
  std::vector<Point> x;
  for (std::size_t i = 0; i < path.hops(); ++i) {
    x.push_back(path.x[i] + d.jacobians[i] * shift);
    for (int a = 0; second && a < 3; ++a) {
      x[i][a] += 0.5 * shift.dot(d.hessians[i][a] * shift);
    }
  }
  return x;
}

double largest_distance(const std::vector<Point>& a, const std::vector<Point>& b) {
  double distance = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) distance = std::max(distance, (a[i] - b[i]).norm());
  return distance;
}

}  // namespace

PathDerivatives path_derivatives(const SpecularChain& chain, const SpecularPath& path,
                                 bool hessians) {
  PathDerivatives result;
  const auto n = static_cast<Eigen::Index>(path.hops());
  const auto lu = fermat_system(chain, path).A.eval().partialPivLu();
  result.determinant = cross_section(chain, path, lu.determinant());

  // A z_p = −F_p: p enters by the last segment only (S32).
  const Vec3 last = path.segment(n);
  const double length = last.norm();
  const Vec3 w = last / length;
  Columns F_p = Columns::Zero(4 * n, 3);
  F_p.block<3, 3>(4 * (n - 1), 0) =
      -(index_along(chain, n) / length) * (Mat3::Identity() - w * w.transpose());
  const Columns z_p = -lu.solve(F_p);
  result.finite = z_p.allFinite() && std::isfinite(result.determinant);
  for (Eigen::Index i = 0; i < n; ++i) result.jacobians.push_back(z_p.block<3, 3>(4 * i, 0));
  if (!hessians) return result;

  result.hessians.resize(n);
  const Motion motion{z_p, n};
  for (int b = 0; b < 3; ++b) {
    for (int c = 0; c <= b; ++c) {
      const PathVector z_bc = -lu.solve(second_residual(chain, path, motion, b, c));
      result.finite &= z_bc.allFinite();
      for (Eigen::Index i = 0; i < n; ++i) {
        for (int a = 0; a < 3; ++a) {
          result.hessians[i][a](b, c) = result.hessians[i][a](c, b) = z_bc[4 * i + a];
        }
      }
    }
  }
  return result;
}

PathPrediction perturb(const SpecularChain& chain, const SpecularPath& path,
                       const PathDerivatives& derivatives, const Vec3& shift) {
  PathPrediction result;
  result.first = predicted(path, derivatives, shift, false);
  result.second = predicted(path, derivatives, shift, true);
  PolishResult exact = polish(chain, {path.from, path.to + shift, result.second, {}});
  result.exact = std::move(exact.path);
  result.converged = exact.converged && obeys_optics(chain, result.exact);
  if (!result.converged) return result;
  result.first_error = largest_distance(result.first, result.exact.x);
  result.second_error = largest_distance(result.second, result.exact.x);
  return result;
}

}  // namespace caustic::solver
