#include "solver/path_derivatives.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "solver/forward_map.h"
#include "tests/support/random_path.h"
#include "tests/support/sampling.h"
#include "tests/support/scenes.h"
#include "tests/support/thorough.h"

namespace caustic::solver {
namespace {

using test::Random;
using test::RandomPath;

constexpr int kReferencePaths = test::thorough(25, 2), kPaths = test::thorough(400, 30);

// Required of J and H: error in units of their natural scale.
constexpr double kPathTolerance = 1e-11;

// Scales of J and H with what a rounding of the path's points does to them: near a caustic one ε of
// x moves J by the response |J|, times |J| again, …; here paths are kept where that is moderate.
struct Scale {
  double J = 1.0, H = 1.0;
};
Scale scale_of(const PathDerivatives& d) {
  Scale scale;
  for (const Mat3& J : d.jacobians) scale.J = std::max(scale.J, J.norm());
  for (const auto& H : d.hessians) {
    for (const Mat3& layer : H) scale.H = std::max(scale.H, layer.norm());
  }
  return scale;
}

// A path with derivatives of moderate size.
RandomPath moderate_path(int hops, Random& random) {
  for (;;) {
    RandomPath r = test::random_path(hops, random);
    const auto polished = polish(r.chain, r.path);
    if (!polished.converged) {
      ADD_FAILURE() << "a path that was traced does not polish";
      continue;
    }
    r.path = polished.path;
    const Scale scale = scale_of(path_derivatives(r.chain, r.path, true));
    if (scale.J < 10.0 && scale.H < 100.0) return r;
  }
}

TEST(PathDerivatives, AgreeWithFiftyDigits) {
  Random random(7001);
  for (int hops = 1; hops <= 3; ++hops) {
    double worst_x = 0, worst_J = 0, worst_H = 0, worst_D = 0, worst_L = 0;
    for (int k = 0; k < kReferencePaths; ++k) {
      const RandomPath r = moderate_path(hops, random);
      const auto d = path_derivatives(r.chain, r.path, true);
      ASSERT_TRUE(d.finite);
      const auto reference = test::reference_path(r.hops, r.path.from, r.path.to, r.path.x);
      const Scale scale = scale_of(d);
      for (int i = 0; i < hops; ++i) {
        worst_x = std::max(worst_x, (r.path.x[i] - reference.x[i]).norm());
        worst_J = std::max(worst_J, (d.jacobians[i] - reference.jacobians[i]).norm() / scale.J);
        for (int a = 0; a < 3; ++a) {
          worst_H =
              std::max(worst_H, (d.hessians[i][a] - reference.hessians[i][a]).norm() / scale.H);
        }
      }
      worst_D = std::max(worst_D, std::abs(d.determinant / reference.determinant - 1.0));
      worst_L =
          std::max(worst_L, std::abs(optical_length(r.chain, r.path) - reference.optical_length));
    }
    EXPECT_LT(worst_x, kPathTolerance) << hops << " hops";
    EXPECT_LT(worst_J, kPathTolerance) << hops << " hops";
    EXPECT_LT(worst_H, kPathTolerance) << hops << " hops";
    EXPECT_LT(worst_D, kPathTolerance) << hops << " hops";
    EXPECT_LT(worst_L, kPathTolerance) << hops << " hops";
  }
}

// [C] (2.33) as it stands, from the light towards p, with the signs of NOTATION: a second way to J.
std::vector<Mat3> jacobians_by_recurrence(const SpecularChain& chain, const SpecularPath& path) {
  using Mat43 = Eigen::Matrix<double, 4, 3>;
  const auto [F, A] = fermat_system(chain, path);
  const auto n = static_cast<int>(path.hops());
  std::vector<Mat3> reflection(n);  // ∂x_i/∂x_{i+1}, the light's side settled
  for (int i = 0; i < n; ++i) {
    Eigen::Matrix4d gamma = A.block<4, 4>(4 * i, 4 * i);
    if (i > 0) {
      const Mat3 before = A.block<3, 3>(4 * i, 4 * i - 4);
      gamma.topLeftCorner<3, 3>() += before * reflection[i - 1];
    }
    Mat43 T = Mat43::Zero();
    const Vec3 along = path.segment(i + 1);
    const Vec3 w = along.normalized();
    T.topRows<3>() =
        -(index_along(chain, i + 1) / along.norm()) * (Mat3::Identity() - w * w.transpose());
    const Mat43 D = -gamma.fullPivLu().solve(T);
    reflection[i] = D.topRows<3>();
  }
  std::vector<Mat3> jacobians(n);
  Mat3 product = Mat3::Identity();
  for (int i = n - 1; i >= 0; --i) jacobians[i] = product = reflection[i] * product;
  return jacobians;
}

TEST(PathDerivatives, JacobiansAgreeWithTheRecurrenceOfChen) {
  Random random(7002);
  double worst = 0.0;
  for (int k = 0; k < kPaths; ++k) {
    const RandomPath r = moderate_path(1 + k % 4, random);
    const auto d = path_derivatives(r.chain, r.path, false);
    const auto other = jacobians_by_recurrence(r.chain, r.path);
    for (std::size_t i = 0; i < other.size(); ++i) {
      worst = std::max(worst, (d.jacobians[i] - other[i]).norm() / scale_of(d).J);
    }
  }
  EXPECT_LT(worst, kPathTolerance);
}

// One mirror: J [u v] = [e1 e2] M⁻¹ of the forward map (S7), and the determinant is a, freed of the
// receiver and of the first surface: (S34).
TEST(PathDerivatives, OfOneMirrorAgreeWithTheForwardMap) {
  Random random(7003);
  double worst_J = 0.0, worst_D = 0.0;
  for (int k = 0; k < kPaths; ++k) {
    RandomPath r = moderate_path(1, random);
    while (!r.chain[0].reflects) r = moderate_path(1, random);
    const Vec3 arriving = r.path.segment(1).normalized();
    const Vec3 across = (arriving + 0.4 * random.direction()).normalized();
    const geometry::Frame frame(across);
    const auto receiver =
        geometry::ReceiverFrame::make(r.path.to, frame.e1, frame.e2, geometry::Vec2(2.0, 2.0));
    const auto system = test::one_mirror(PointLight{r.path.from, 1.0}, r.shapes[0], receiver);
    Vec3 N;
    r.shapes[0]->value_gradient(r.path.x[0], N);
    const ForwardMap map(system, 0, N.dot(r.path.segment(0)) < 0.0 ? 1 : -1);
    const FieldPoint f = map.evaluate(r.path.x[0]);
    ASSERT_TRUE(f.arrives() && f.lit());
    ASSERT_LT(f.q.norm(), 1e-12);

    const auto d = path_derivatives(r.chain, r.path, false);
    geometry::Mat2 M;
    M << f.q_s, f.q_t;
    Eigen::Matrix<double, 3, 2> e, axes;
    e << f.e1, f.e2;
    axes << receiver.u, receiver.v;
    worst_J = std::max(worst_J, (d.jacobians[0] * axes - e * M.inverse()).norm() / scale_of(d).J);
    const double D = f.a * receiver.m.dot(arriving) * r.path.segment(0).squaredNorm() / f.cos_alpha;
    worst_D = std::max(worst_D, std::abs(d.determinant / D - 1.0));
  }
  EXPECT_LT(worst_J, kPathTolerance);
  EXPECT_LT(worst_D, kPathTolerance);
}

TEST(PathDerivatives, AgreeWithDifferencesOfPaths) {
  Random random(7004);
  for (int k = 0; k < kPaths / 8; ++k) {
    const RandomPath r = moderate_path(1 + k % 3, random);
    const auto d = path_derivatives(r.chain, r.path, true);
    const Scale scale = scale_of(d);
    const double h = 1e-5;
    const Vec3 along = random.direction();
    const auto at = [&](double t) {
      SpecularPath start = r.path;
      start.to += t * along;
      const auto result = polish(r.chain, start);
      EXPECT_TRUE(result.converged);
      return result.path.x;
    };
    const auto forth = at(h), back = at(-h);
    for (std::size_t i = 0; i < forth.size(); ++i) {
      const Vec3 first = (forth[i] - back[i]) / (2.0 * h);
      const Vec3 second = (forth[i] + back[i] - 2.0 * r.path.x[i]) / (h * h);
      Vec3 H;
      for (int a = 0; a < 3; ++a) H[a] = along.dot(d.hessians[i][a] * along);
      EXPECT_LT((d.jacobians[i] * along - first).norm(), 1e-6 * scale.H * scale.J);
      EXPECT_LT((H - second).norm(), 1e-3 * scale.H * scale.J);
    }
  }
}

// |x(p + tΔ) − prediction| falls by 4 and by 8 when t is halved.
TEST(PathDerivatives, PredictionsConvergeWithOrderTwoAndThree) {
  Random random(7005);
  int tried = 0;
  for (int k = 0; k < kPaths / 4; ++k) {
    const RandomPath r = moderate_path(1 + k % 3, random);
    const auto d = path_derivatives(r.chain, r.path, true);
    const Vec3 shift = 0.004 / scale_of(d).H * random.direction();
    const auto whole = perturb(r.chain, r.path, d, shift);
    const auto half = perturb(r.chain, r.path, d, 0.5 * shift);
    ASSERT_TRUE(whole.converged && half.converged);
    // Only where rounding of x leaves digits to compare, and the leading term leads.
    if (half.second_error < 1e-12) continue;
    ++tried;
    EXPECT_NEAR(std::log2(whole.first_error / half.first_error), 2.0, 0.15);
    EXPECT_NEAR(std::log2(whole.second_error / half.second_error), 3.0, 0.3);
  }
  EXPECT_GT(tried, kPaths / 16);
}

// The same path the other way: same points, n² × the cross-section there = n² × that here.
TEST(PathDerivatives, ReciprocityOfTheCrossSection) {
  Random random(7006);
  for (int k = 0; k < kPaths; ++k) {
    const RandomPath r = moderate_path(1 + k % 4, random);
    const std::size_t n = r.path.hops();
    SpecularChain chain;
    SpecularPath start{r.path.to, r.path.from, {}, {}};
    for (std::size_t i = n; i-- > 0;) {
      chain.push_back(
          {r.chain[i].shape, r.chain[i].reflects, r.chain[i].index_after, r.chain[i].index_before});
      start.x.push_back(r.path.x[i] + 1e-4 * random.direction());
    }
    const auto back = polish(chain, start);
    ASSERT_TRUE(back.converged);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_LT((back.path.x[i] - r.path.x[n - 1 - i]).norm(), 1e-11);
    }
    const double here = path_derivatives(r.chain, r.path, false).determinant;
    const double there = path_derivatives(chain, back.path, false).determinant;
    const double n0 = index_along(r.chain, 0), nN = index_along(r.chain, n);
    EXPECT_NEAR(n0 * n0 / here * there / (nN * nN), 1.0, 1e-9);
  }
}

TEST(PathDerivatives, OfAPlaneMirrorAreThoseOfTheMirroredSource) {
  const auto plane = geometry::make_plane({0, 0, 0}, {0, 0, 1});
  const SpecularChain chain{{plane.get()}};
  const auto result = polish(chain, {{0, 0, 1}, {3, 0, 2}, {{0.5, 0.5, 0}}, {}});
  ASSERT_TRUE(result.converged);
  EXPECT_LT((result.path.x[0] - Point(1, 0, 0)).norm(), 1e-14);
  const auto d = path_derivatives(chain, result.path, false);
  EXPECT_NEAR(d.determinant, 18.0, 1e-13);  // distance² from the mirrored source
  EXPECT_NEAR(optical_length(chain, result.path), std::sqrt(18.0), 1e-14);
}

// A straight crossing solves the equations of reflection with λ = 0; light is not sent that way.
TEST(PathDerivatives, StraightCrossingsAreNotReflections) {
  const auto sphere = geometry::make_sphere({0, 0, 0}, 1.0);
  const SpecularChain chain{{sphere.get()}};
  const auto result = polish(chain, {{0, 0, 0.5}, {0.2, 0, 3}, {{0.05, 0, 1.0}}, {}});
  ASSERT_TRUE(result.converged);
  EXPECT_NEAR(result.path.lambda[0], 0.0, 1e-14);
  EXPECT_FALSE(obeys_optics(chain, result.path));
  const auto reflection = polish(chain, {{0, 0, 0.5}, {0.2, 0, 0.4}, {{0.1, 0, 1.0}}, {}});
  ASSERT_TRUE(reflection.converged);
  EXPECT_TRUE(obeys_optics(chain, reflection.path));
}

}  // namespace
}  // namespace caustic::solver
