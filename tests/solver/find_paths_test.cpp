#include "solver/find_paths.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/random.h"
#include "tests/support/scenes.h"
#include "tests/support/thorough.h"

namespace caustic::solver {
namespace {

using test::Random;

constexpr int kPairs = test::thorough(300, 15);

OpticalSystem scene_of(std::vector<SystemSurface> surfaces) {
  return OpticalSystem::build(PointLight{{0, 0, 4}, 1.0}, std::move(surfaces),
                              test::floor_at({0, 0, -1}, 4.0, 4.0));
}

PathFinder::Answer paths(const OpticalSystem& system, const Family& family, const Point& from,
                         const Point& to) {
  return PathFinder(system, family, PointLight{from, 1.0}).to(to);
}

// The mirror sphere seen from outside: one path, unless the sphere stands between the points.
TEST(FindPaths, ConvexSphereHasExactlyOne) {
  const auto system = scene_of({test::mirror(geometry::make_sphere({0, 0, 0}, 1.0))});
  Random random(7101);
  for (int k = 0; k < kPairs; ++k) {
    const Point from = random.uniform(1.01, 4.0) * random.direction();
    const Point to = random.uniform(1.01, 4.0) * random.direction();
    const double t = std::clamp(-from.dot(to - from) / (to - from).squaredNorm(), 0.0, 1.0);
    const double nearest = (from + t * (to - from)).norm();
    if (std::abs(nearest - 1.0) < 1e-6) continue;
    const auto found = paths(system, {0}, from, to);
    EXPECT_EQ(found.paths.size(), nearest > 1.0 ? 1u : 0u)
        << from.transpose() << " to " << to.transpose();
    EXPECT_EQ(found.undecided, 0u);
  }
}

// Alhazen's problem is plane: all paths lie in the plane of the two points and the centre, and are
// the stationary points of the length on a circle. Counted by changes of sign of its slope.
int alhazen_count(const Point& from, const Point& to, double& margin) {
  const Vec3 e1 = from.normalized();
  const Vec3 e2 = (to - to.dot(e1) * e1).normalized();
  const geometry::Vec2 a(from.norm(), 0.0), b(to.dot(e1), to.dot(e2));
  const auto slope = [&](double angle) {
    const geometry::Vec2 x(std::cos(angle), std::sin(angle)), t(-x.y(), x.x());
    return t.dot(x - a) / (x - a).norm() + t.dot(x - b) / (x - b).norm();
  };
  constexpr int kSteps = 4000;
  int changes = 0;
  double last = slope(0.0);
  margin = 1.0;
  for (int k = 1; k <= kSteps; ++k) {
    const double value = slope(2.0 * geometry::kPi * k / kSteps);
    changes += (value > 0.0) != (last > 0.0);
    // A minimum of |slope| without a change of sign may hide a pair.
    const double next = slope(2.0 * geometry::kPi * (k + 1) / kSteps);
    if ((value > 0) == (last > 0) && (value > 0) == (next > 0) &&
        std::abs(value) <= std::abs(last) && std::abs(value) <= std::abs(next)) {
      margin = std::min(margin, std::abs(value));
    }
    last = value;
  }
  return changes;
}

TEST(FindPaths, ConcaveSphereHasTwoOrFour) {
  const auto system = scene_of({test::mirror(geometry::make_sphere({0, 0, 0}, 1.0))});
  Random random(7102);
  int twos = 0, fours = 0;
  for (int k = 0; k < kPairs; ++k) {
    const Point from = random.uniform(0.05, 0.99) * random.direction();
    const Point to = random.uniform(0.05, 0.99) * random.direction();
    double margin;
    const int expected = alhazen_count(from, to, margin);
    if (margin < 1e-6) continue;  // the oracle does not tell a pair from none
    const auto found = paths(system, {0}, from, to);
    EXPECT_EQ(static_cast<int>(found.paths.size()), expected)
        << from.transpose() << " to " << to.transpose() << ", margin " << margin;
    twos += expected == 2;
    fours += expected == 4;
  }
  EXPECT_GT(twos, kPairs / 40);
  EXPECT_GT(fours, kPairs / 40);
  EXPECT_GT(twos + fours, kPairs * 9 / 10);
}

// A light that nearly touches its mirror sees all of it in cells as small as its distance.
TEST(FindPaths, FromALightBesideItsMirror) {
  const auto system = scene_of({test::mirror(geometry::make_plane({0, 0, 0}, {0, 0, 1}))});
  for (const double height : {1e-1, 1e-2, 1e-3, 1e-4}) {
    const Point from(0.3, 0.2, height), to(1.5, -0.7, 0.8);
    const auto found = paths(system, {0}, from, to);
    ASSERT_EQ(found.paths.size(), 1u) << height;
    const Point expected = from + height / (height + 0.8) * (to - from);
    EXPECT_LT((found.paths[0].path.x[0].head<2>() - expected.head<2>()).norm(), 1e-11);
  }
}

// Two plane mirrors at a right angle: the path goes over the twice mirrored point.
TEST(FindPaths, OfTwoPlaneMirrorsAreThoseOfTheMirroredPoint) {
  const auto system = scene_of({test::mirror(geometry::make_plane({0, 0, 0}, {0, 0, 1})),
                                test::mirror(geometry::make_plane({0, 0, 0}, {1, 0, 0}))});
  Random random(7103);
  for (int k = 0; k < kPairs / 12; ++k) {
    const Point from(random.uniform(0.2, 3), random.uniform(-2, 2), random.uniform(0.2, 3));
    const Point to(random.uniform(0.2, 3), random.uniform(-2, 2), random.uniform(0.2, 3));
    const Point image(-from.x(), from.y(), -from.z());
    // The line from the image meets the planes x = 0 and z = 0 in the order of the family.
    const double tx = -image.x() / (to.x() - image.x()), tz = -image.z() / (to.z() - image.z());
    const auto found = paths(system, {0, 1}, from, to);
    ASSERT_EQ(found.paths.size(), tz < tx ? 1u : 0u);
    if (found.paths.empty()) continue;
    EXPECT_NEAR(optical_length(found.paths[0].chain, found.paths[0].path), (to - image).norm(),
                1e-12);
    const Point last = image + tx * (to - image);
    EXPECT_LT((found.paths[0].path.x[1] - last).norm(), 1e-11);
  }
}

// From from to to by [A, B] and back by [B, A] the points are the same.
TEST(FindPaths, TheSameBothWays) {
  const auto system = scene_of(
      {test::mirror(geometry::make_torus({0, 0, 0}, {0, 0, 1}, 1.5, 0.5)),
       test::mirror(geometry::make_ellipsoid({0, 0, 3}, {2.0, 1.0, 0.7}, Mat3::Identity()))});
  Random random(7104);
  int found_any = 0;
  for (int k = 0; k < test::thorough(10, 2); ++k) {
    const Point from = random.in_cube(3.0) + Vec3(0, 0, 1.5),
                to = random.in_cube(3.0) + Vec3(0, 0, 1.5);
    for (const Family& family : {Family{0}, Family{1}, Family{0, 1}}) {
      const auto forth = paths(system, family, from, to);
      const auto back = paths(system, Family(family.rbegin(), family.rend()), to, from);
      EXPECT_EQ(forth.paths.size(), back.paths.size())
          << family.size() << " hops, " << from.transpose() << " to " << to.transpose();
      for (const FamilyPath& a : forth.paths) {
        double nearest = 1.0;
        for (const FamilyPath& b : back.paths) {
          nearest = std::min(nearest, (a.path.x.front() - b.path.x.back()).norm());
        }
        EXPECT_LT(nearest, 1e-8);
      }
      found_any += !forth.paths.empty();
    }
  }
  EXPECT_GT(found_any, test::thorough(5, 0));
}

SystemSurface glass(geometry::SurfacePtr shape, double index) {
  SystemSurface surface = test::mirror(std::move(shape));
  surface.optics.kind = Optics::Kind::refract;
  surface.optics.index_inside = index;
  return surface;
}

// Water below z = 0: the crossing r of the plane solves sin i = n sin t, one equation by bisection.
TEST(FindPaths, ThroughAPlaneInterfaceFollowSnell) {
  const auto system = scene_of({glass(geometry::make_plane({0, 0, 0}, {0, 0, 1}), 1.33)});
  Random random(7105);
  for (int k = 0; k < kPairs / 6; ++k) {
    const double height = random.uniform(0.2, 3.0), depth = random.uniform(0.2, 3.0);
    const double distance = random.uniform(0.1, 5.0),
                 angle = random.uniform(0.0, 2 * geometry::kPi);
    const Vec3 across(std::cos(angle), std::sin(angle), 0.0);
    const Point from = height * Vec3::UnitZ(), to = distance * across - depth * Vec3::UnitZ();
    double lo = 0.0, hi = distance;
    for (int i = 0; i < 100; ++i) {
      const double r = 0.5 * (lo + hi), s = distance - r;
      (r / std::hypot(r, height) < 1.33 * s / std::hypot(s, depth) ? lo : hi) = r;
    }
    for (const bool down : {true, false}) {
      const auto found = down ? paths(system, {0}, from, to) : paths(system, {0}, to, from);
      ASSERT_EQ(found.paths.size(), 1u);
      EXPECT_LT((found.paths[0].path.x[0] - lo * across).norm(), 1e-9);
    }
    // From one side to the same side nothing is refracted.
    EXPECT_TRUE(paths(system, {0}, from, from + across).paths.empty());
  }
}

// What a finder remembers of earlier questions, close together and far apart, changes no answer: a
// new one knows nothing.
TEST(FindPaths, AnswersDoNotDependOnEarlierQuestions) {
  const auto system = scene_of(
      {test::mirror(geometry::make_ellipsoid({0, 0, 0}, {2.6, 2.2, 3.0}, Mat3::Identity())),
       test::mirror(geometry::make_torus({0, 0, 0.4}, Vec3(1, 2, 2) / 3.0, 1.0, 0.3))});
  for (const Family& family : {Family{0}, Family{1}, Family{1, 0}}) {
    Random random(7106);
    PathFinder finder(system, family, PointLight{{0.3, 0.2, -1.5}, 1.0});
    std::size_t compared = 0, most = 0;
    for (int k = 0; k < 5 * kPairs; ++k) {
      // Two patches of a plane, all of space about the scene, and far away.
      Point p(random.uniform(-1.5, -0.5), random.uniform(-1, 1), -1.0);
      if (k % 3 == 1) p = {random.uniform(1.0, 1.01), random.uniform(0.5, 0.51), 0.7};
      if (k % 10 == 0) p = random.in_cube(2.0);
      if (k % 50 == 0) p *= 40.0;
      const auto used = finder.to(p);
      if (k % 10 > 2) continue;
      const auto fresh = PathFinder(system, family, finder.tracer().light()).to(p);
      ASSERT_EQ(used.paths.size(), fresh.paths.size()) << k << ": " << p.transpose();
      for (std::size_t i = 0; i < used.paths.size(); ++i) {
        EXPECT_LT((used.paths[i].path.x[0] - fresh.paths[i].path.x[0]).norm(), 1e-11);
      }
      compared += used.paths.size();
      most = std::max(most, used.paths.size());
    }
    EXPECT_GT(compared, static_cast<std::size_t>(kPairs / 2));
    EXPECT_GE(most, 2u);
  }
}

// Every path of an ellipsoid between its foci: not a list, and it does not hang.
TEST(FindPaths, PerfectFocusIsUndecided) {
  const auto system = scene_of(
      {test::mirror(geometry::make_ellipsoid({0, 0, 0}, {1.25, 1.0, 1.0}, Mat3::Identity()))});
  EXPECT_GT(paths(system, {0}, {0.75, 0, 0}, {-0.75, 0, 0}).undecided, 0u);
}

}  // namespace
}  // namespace caustic::solver
