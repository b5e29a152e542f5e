#include "solver/certify_paths.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>

#include "geometry/expression/field.h"
#include "solver/paths_between.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"
#include "tests/support/thorough.h"

namespace caustic::solver {
namespace {

using test::Random;

constexpr int kCertifiedPairs = test::thorough(40, 5);  // 1000 by ISOCAUSTIC_PAIRS=1000

int pairs() {
  const char* wanted = std::getenv("ISOCAUSTIC_PAIRS");
  return wanted ? std::atoi(wanted) : kCertifiedPairs;
}

struct Agreement {
  int pairs = 0, paths = 0, most = 0, undecided = 0;
};

// The search and the proof find the same paths, pair by pair.
Agreement compare(const geometry::SurfacePtr& shape, double half, std::uint64_t seed) {
  const auto system = OpticalSystem::build(PointLight{{0, 0, half}, 1.0}, {test::mirror(shape)},
                                           test::floor_at({0, 0, -half}, 2.0 * half, 2.0 * half));
  Random random(seed);
  Agreement sum;
  for (int k = 0; k < pairs(); ++k) {
    PathsRequest request;
    request.from = random.in_cube(half);
    request.to = random.in_cube(half);
    const auto fast = paths_between(system, request);
    request.certify = true;
    const auto certified = paths_between(system, request);
    ++sum.pairs;
    sum.undecided += !certified.certified;
    EXPECT_EQ(fast.undecided, 0u);
    EXPECT_EQ(fast.paths.size(), certified.paths.size())
        << "pair " << k << ": " << request.from.transpose() << " to " << request.to.transpose();
    if (fast.paths.size() != certified.paths.size()) continue;
    for (std::size_t i = 0; i < fast.paths.size(); ++i) {
      EXPECT_LT((fast.paths[i].way.path.x[0] - certified.paths[i].way.path.x[0]).norm(), 1e-9);
    }
    sum.paths += static_cast<int>(fast.paths.size());
    sum.most = std::max(sum.most, static_cast<int>(fast.paths.size()));
  }
  std::cout << sum.paths << " paths of " << sum.pairs << " pairs, at most " << sum.most << "; "
            << sum.undecided << " undecided\n";
  EXPECT_EQ(sum.undecided, 0);
  return sum;
}

TEST(CertifyPaths, AgreesWithTheSearchInASphere) {
  EXPECT_GE(compare(geometry::make_sphere({0, 0, 0}, 1.75), 1.0, 7201).most, 4);
}
TEST(CertifyPaths, AgreesWithTheSearchOutsideASphere) {
  EXPECT_EQ(compare(geometry::make_sphere({0.1, 0.2, 0}, 0.7), 3.0, 7202).most, 1);
}
TEST(CertifyPaths, AgreesWithTheSearchInAnEllipsoid) {
  const Mat3 turned = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  EXPECT_GE(compare(geometry::make_ellipsoid({0, 0, 0}, {1.5, 2.0, 1.2}, turned), 1.0, 7203).most,
            4);
}
TEST(CertifyPaths, AgreesWithTheSearchAroundATorus) {
  const auto torus = geometry::make_torus({0, 0, 0}, Vec3(1, 1, 2).normalized(), 1.2, 0.5);
  EXPECT_GE(compare(torus, 2.0, 7204).most, 2);
}
TEST(CertifyPaths, AgreesWithTheSearchAroundAVase) {
  // [C] fig. 3.4: a = 5.80, b = −9.78, c = 3.90, d = 0.47, two units high.
  const auto vase =
      geometry::make_revolution({0, 0, -1}, {0, 0, 1}, 2.0, {0.47, 3.90, -9.78, 5.80});
  EXPECT_GE(compare(vase.surface, 2.0, 7206).most, 2);
}
TEST(CertifyPaths, AgreesWithTheSearchAroundACuboid) {
  // [MH] Plate 4; its expression vanishes at the centre as well.
  const auto cuboid =
      geometry::make_expression(geometry::read_expression("x^4+y^4+z^4-x^2-y^2-z^2", 1.0),
                                geometry::Box::around(Point::Zero(), 1.3),
                                geometry::Pose::make({0, 0, 1}, 0.0, Vec3::Zero()));
  // Few pairs may all have one path.
  EXPECT_GE(compare(cuboid.surface, 2.0, 7209).most, pairs() >= 40 ? 3 : 1);
}

TEST(CertifyPaths, AgreesWithTheSearchAtAPlane) {
  EXPECT_EQ(compare(geometry::make_plane({0, 0, 0.1}, Vec3(1, 0, 3).normalized()), 2.0, 7205).most,
            1);
}

// Two hops: the product of both boxes, pruned hop by hop.
TEST(CertifyPaths, AgreesWithTheSearchOverTwoMirrors) {
  const auto system = OpticalSystem::build(PointLight{{3, 0, 2}, 1.0},
                                           {test::mirror(geometry::make_sphere({0, 0, 0}, 1.0)),
                                            test::mirror(geometry::make_sphere({0, 0, 4}, 1.5))},
                                           test::floor_at({0, 0, -1}, 4.0, 4.0));
  Random random(7207);
  int paths = 0;
  for (int k = 0; k < pairs() / 5; ++k) {
    PathsRequest request;
    request.from = random.in_cube(2.0) + Vec3(3, 0, 2);
    request.to = random.in_cube(2.0) + Vec3(-3, 0, 2);
    request.families = {{0, 1}, {1, 0}};
    const auto fast = paths_between(system, request);
    request.certify = true;
    const auto certified = paths_between(system, request);
    EXPECT_TRUE(certified.certified);
    ASSERT_EQ(fast.paths.size(), certified.paths.size());
    for (std::size_t i = 0; i < fast.paths.size(); ++i) {
      EXPECT_EQ(fast.paths[i].family_id, certified.paths[i].family_id);
      EXPECT_LT((fast.paths[i].way.path.x[1] - certified.paths[i].way.path.x[1]).norm(), 1e-9);
    }
    paths += static_cast<int>(fast.paths.size());
  }
  EXPECT_GT(paths, pairs() / 10);
}

// From air through water to a mirror ball, the other end in the water.
TEST(CertifyPaths, AgreesWithTheSearchUnderWater) {
  SystemSurface water = test::mirror(geometry::make_plane({0, 0, 0}, {0, 0, 1}),
                                     geometry::box_aperture({-4, -4, -1}, {4, 4, 1}));
  water.optics.kind = Optics::Kind::refract;
  water.optics.index_inside = 1.33;
  const auto system = OpticalSystem::build(
      PointLight{{0, 0, 2}, 1.0}, {water, test::mirror(geometry::make_sphere({0, 0, -3}, 1.0))},
      test::floor_at({0, 0, -5}, 4.0, 4.0));
  Random random(7208);
  int paths = 0;
  for (int k = 0; k < pairs() / 5; ++k) {
    PathsRequest request;
    request.from = Vec3(0, 0, 2) + random.in_cube(1.0);
    request.to = Vec3(2.5, 0, -1.5) + random.in_cube(0.8);
    request.families = {{0, 1}};
    const auto fast = paths_between(system, request);
    request.certify = true;
    const auto certified = paths_between(system, request);
    EXPECT_TRUE(certified.certified);
    ASSERT_EQ(fast.paths.size(), certified.paths.size());
    for (std::size_t i = 0; i < fast.paths.size(); ++i) {
      EXPECT_LT((fast.paths[i].way.path.x[1] - certified.paths[i].way.path.x[1]).norm(), 1e-9);
    }
    paths += static_cast<int>(fast.paths.size());
  }
  EXPECT_GE(paths, pairs() / 10);
}

// In at one place of a ball and out at another: the same surface follows itself, and no chord is
// too short to be told from none.
TEST(CertifyPaths, AgreesWithTheSearchThroughABall) {
  SystemSurface ball = test::mirror(geometry::make_sphere({0, 0, 0}, 1.0));
  ball.optics.kind = Optics::Kind::refract;
  ball.optics.index_inside = 1.5;
  const auto system = OpticalSystem::build(PointLight{{0, 0, 3}, 1.0}, {ball},
                                           test::floor_at({0, 0, -2}, 4.0, 4.0));
  const PathSurface hop = path_surface(system.surfaces()[0]);
  const geometry::Box& region = system.surfaces()[0].region;
  Random random(99);
  std::size_t paths = 0;
  const int count = std::clamp(pairs() / 10, 1, 4);
  for (int k = 0; k < count; ++k) {
    const Point from = random.uniform(1.2, 3.5) * random.direction();
    const Point to = random.uniform(1.2, 3.5) * random.direction();
    const auto proven =
        certify_paths({hop, hop}, {region, region}, PointLight{from, 1.0}, to, system.diameter());
    EXPECT_EQ(proven.undecided, 0u) << proven.boxes << " boxes";
    PathFinder finder(system, {0, 0}, PointLight{from, 1.0});
    std::size_t admitted = 0;
    for (const auto& root : proven.roots) admitted += finder.admit(root, to).has_value();
    EXPECT_EQ(admitted, finder.to(to).paths.size());
    paths += admitted;
  }
  EXPECT_TRUE(count < 4 || paths > 0);
}

TEST(CertifyPaths, AWholeCircleOfPathsStaysUndecided) {
  // Both points on the axis of a torus: every path can be turned about it.
  const auto torus = geometry::make_torus({0, 0, 0}, {0, 0, 1}, 1.2, 0.5);
  const auto system = OpticalSystem::build(PointLight{{0, 0, 2}, 1.0}, {test::mirror(torus)},
                                           test::floor_at({0, 0, -1}, 2.0, 2.0));
  const auto result = certify_paths({path_surface(system.surfaces()[0])},
                                    {system.surfaces()[0].region}, PointLight{{0, 0, 1.5}, 1.0},
                                    {0, 0, -1}, system.diameter(), {.max_boxes = 20000});
  EXPECT_GT(result.undecided, 0u);
}

// Straight crossings solve the equations of reflection; a box that holds only those is no path.
TEST(CertifyPaths, CountsNoStraightCrossings) {
  const auto sphere = geometry::make_sphere({0, 0, 0}, 1.0);
  const auto system = OpticalSystem::build(PointLight{{0, 0, 3}, 1.0}, {test::mirror(sphere)},
                                           test::floor_at({0, 0, -1}, 2.0, 2.0));
  const auto result =
      certify_paths({path_surface(system.surfaces()[0])}, {system.surfaces()[0].region},
                    PointLight{{0.1, 0.2, 0.3}, 1.0}, {0.4, 0.1, 3.0}, system.diameter());
  EXPECT_EQ(result.undecided, 0u);
  const Vec3 way = Vec3(0.4, 0.1, 3.0) - Vec3(0.1, 0.2, 0.3);
  for (const auto& root : result.roots) {
    // Off the straight line, and met from the side on which it is left.
    const Point& x = root[0];
    EXPECT_GT(way.normalized().cross(x - Vec3(0.1, 0.2, 0.3)).norm(), 1e-3);
    EXPECT_LT(x.dot(x - Vec3(0.1, 0.2, 0.3)) * x.dot(Vec3(0.4, 0.1, 3.0) - x), 0.0);
  }
}

}  // namespace
}  // namespace caustic::solver
