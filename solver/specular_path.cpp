#include "solver/specular_path.h"

#include <Eigen/LU>
#include <cmath>

namespace caustic::solver {

namespace {

constexpr int kMaxIterations = 40;
// A step moves a point by at most this share of the shorter segment beside it: the direction of a
// segment, and with it the linearisation, holds no further.
constexpr double kStepShare = 0.5;
// A step below this share of the path's extent is rounding if the next one is not a quarter of it.
constexpr double kRounding = 1e-9;
// No step gets smaller than a few roundings of the coordinates.
constexpr double kRoundingStep = 4.0 * geometry::kEpsilon;

double extent(const SpecularPath& path) {
  double size = 0.0;
  for (std::size_t i = 0; i <= path.hops() + 1; ++i) {
    size = std::max(size, path.vertex(i).cwiseAbs().maxCoeff());
  }
  for (std::size_t k = 0; k <= path.hops(); ++k) size = std::max(size, path.segment(k).norm());
  return size;
}

// ∂L/∂xᵢ = n_{i−1} ω_{i−1} − n_i ω_i, ω unit directions along the light.
Vec3 length_gradient(const SpecularChain& chain, const SpecularPath& path, std::size_t i) {
  return index_along(chain, i) * path.segment(i).normalized() -
         index_along(chain, i + 1) * path.segment(i + 1).normalized();
}

}  // namespace

double optical_length(const SpecularChain& chain, const SpecularPath& path) {
  double sum = 0.0;
  for (std::size_t k = 0; k <= path.hops(); ++k) {
    sum += index_along(chain, k) * path.segment(k).norm();
  }
  return sum;
}

void fit_multipliers(const SpecularChain& chain, SpecularPath& path) {
  path.lambda.assign(path.hops(), 0.0);
  for (std::size_t i = 0; i < path.hops(); ++i) {
    Vec3 gradient;
    chain[i].shape->value_gradient(path.x[i], gradient);
    path.lambda[i] = -length_gradient(chain, path, i).dot(gradient) / gradient.squaredNorm();
  }
}

FermatSystem fermat_system(const SpecularChain& chain, const SpecularPath& path) {
  const auto n = static_cast<Eigen::Index>(path.hops());
  FermatSystem system{PathVector::Zero(4 * n), PathMatrix::Zero(4 * n, 4 * n)};
  auto& [F, A] = system;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto d = chain[i].shape->derivatives(path.x[i]);
    F.segment<3>(4 * i) = length_gradient(chain, path, i) + path.lambda[i] * d.gradient;
    F[4 * i + 3] = d.g;
    A.block<3, 3>(4 * i, 4 * i) = path.lambda[i] * d.hessian;
    A.block<3, 1>(4 * i, 4 * i + 3) = d.gradient;
    A.block<1, 3>(4 * i + 3, 4 * i) = d.gradient.transpose();
  }
  // The Hessian of n|b − a| is ±n(I − ωωᵀ)/|b − a| in all four places.
  for (Eigen::Index k = 0; k <= n; ++k) {
    const Vec3 along = path.segment(k);
    const double length = along.norm();
    const Vec3 w = along / length;
    const Mat3 B = (index_along(chain, k) / length) * (Mat3::Identity() - w * w.transpose());
    if (k > 0) A.block<3, 3>(4 * k - 4, 4 * k - 4) += B;
    if (k < n) A.block<3, 3>(4 * k, 4 * k) += B;
    if (k > 0 && k < n) {
      A.block<3, 3>(4 * k - 4, 4 * k) -= B;
      A.block<3, 3>(4 * k, 4 * k - 4) -= B;
    }
  }
  return system;
}

PolishResult polish(const SpecularChain& chain, SpecularPath start) {
  PolishResult result{std::move(start)};
  SpecularPath& path = result.path;
  fit_multipliers(chain, path);
  const auto n = static_cast<Eigen::Index>(path.hops());
  double last = geometry::kInfinity;
  while (result.iterations++ < kMaxIterations) {
    const auto [F, A] = fermat_system(chain, path);
    if (!F.allFinite() || !A.allFinite()) return result;
    const PathVector step = -A.partialPivLu().solve(F);
    if (!step.allFinite()) return result;
    double share = 1.0, size = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double length = step.segment<3>(4 * i).norm();
      const double room = std::min(path.segment(i).norm(), path.segment(i + 1).norm());
      size = std::max(size, length);
      if (length > kStepShare * room) share = std::min(share, kStepShare * room / length);
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      path.x[i] += share * step.segment<3>(4 * i);
      path.lambda[i] += share * step[4 * i + 3];
    }
    const double scale = extent(path);
    result.converged = share == 1.0 && (size <= kRoundingStep * scale ||
                                        (size <= kRounding * scale && size > 0.25 * last));
    if (result.converged) return result;
    last = size;
  }
  return result;
}

bool obeys_optics(const SpecularChain& chain, const SpecularPath& path) {
  for (std::size_t i = 0; i < path.hops(); ++i) {
    Vec3 normal;
    chain[i].shape->value_gradient(path.x[i], normal);
    const double in = normal.dot(path.segment(i)), out = normal.dot(path.segment(i + 1));
    if (!(chain[i].reflects ? in * out < 0.0 : in * out > 0.0)) return false;
  }
  return true;
}

}  // namespace caustic::solver
