// Curves behind random strips, balls and rings against a dense sampling that asks every point.
#include "solver/visible_pieces.h"

#include <gtest/gtest.h>

#include <random>

#include "solver/contours.h"
#include "tests/support/thorough.h"
#include "tests/support/total_scenes.h"

namespace caustic::solver {
namespace {

using namespace geometry;

SystemSurface blocker(std::mt19937_64& random, int i) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const double w = 0.005 + 0.1 * std::abs(uniform(random));
  const Point c(0.5 * uniform(random), 0.5 * uniform(random), 2.2 + 0.8 * uniform(random));
  const Direction n = Vec3(uniform(random), uniform(random), uniform(random)).normalized();
  const Optics black{Optics::Kind::absorb, 1.0};
  const std::string name = "b" + std::to_string(i);
  if (i % 3 == 0) return {name, make_sphere(c, w), {}, black, {}};
  if (i % 3 == 2) return {name, make_torus(c, n, 0.3, 0.02 + 0.1 * w), {}, black, {}};
  const Frame f(n);
  std::vector<Bound> strip{
      half_space_aperture(c + w * f.e1, f.e1), half_space_aperture(c - w * f.e1, -f.e1),
      half_space_aperture(c + 0.3 * f.e2, f.e2), half_space_aperture(c - 0.3 * f.e2, -f.e2)};
  return {name, make_plane(c, n), std::move(strip), black, {}};
}

TEST(VisiblePieces, as_long_as_a_dense_sampling_says) {
  std::mt19937_64 random(7);
  constexpr double chord = 1e-5, coarse = 1e-4;
  for (int trial = 0; trial < 12; ++trial) {
    std::vector<SystemSurface> ball{{"ball", make_sphere({0, 0, 0}, 1.0), {}, {}, {}}};
    auto all = ball;
    for (int i = 0; i <= trial; ++i) all.push_back(blocker(random, i));
    const Light light = trial % 2 ? Light(PointLight{{0.3, 0.2, 4}, 1.0})
                                  : Light(CollimatedLight{Vec3(0.1, 0.05, -1).normalized(), 1.0});
    const auto receiver = ReceiverFrame::make({0, 0, 5}, {1, 0, 0}, {0, 1, 0}, {8, 8});
    const auto free = OpticalSystem::build(light, ball, receiver);
    const auto hidden = OpticalSystem::build(light, all, receiver);

    ContourRequest request;
    request.families = {{0}};
    request.levels.count = 3;
    request.chord_tolerance = chord;
    request.time_limit = 300.0;
    const auto dense = trace_contours(free, request);
    request.levels.values = dense.levels;
    request.chord_tolerance = coarse;
    const auto cut = trace_contours(hidden, request);

    // Blocked or not by the plain definition: a crossing that exists between the ends.
    const auto blocked = [&](const Point& from, const Vec3& way) {
      for (std::size_t i = 1; i < all.size(); ++i) {
        RayParameters roots;
        all[i].shape->crossings({from, way}, 0.0, 1.0, roots);
        for (const double t : roots) {
          if (exists_at(all[i].bounds, from + t * way)) return true;
        }
      }
      return false;
    };
    double expected = 0.0, found = 0.0;
    for (const Curve& c : dense.curves) {
      for (std::size_t i = 0; i + (c.closed ? 0 : 1) < c.vertices.size(); ++i) {
        const CurveVertex &a = c.vertices[i], &b = c.vertices[(i + 1) % c.vertices.size()];
        const Point x = 0.5 * (a.x + b.x), p = 0.5 * (a.p + b.p);
        const auto* point = std::get_if<PointLight>(&light);
        const Vec3 to_light = point ? Vec3(point->position - x)
                                    : Vec3(-20.0 * std::get<CollimatedLight>(light).direction);
        if (!blocked(x, to_light) && !blocked(x, p - x)) expected += (b.p - a.p).norm();
      }
    }
    for (const Curve& c : cut.curves) found += c.length;
    // The sampling errs by a spacing at each end; a piece lost or gained would be longer.
    const double spacing = std::sqrt(8.0 * chord * 4.0);
    EXPECT_NEAR(found, expected, spacing * double(2 + cut.curves.size())) << "trial " << trial;
  }
}

// The room of what is seen is an estimate; here it reaches beyond the place where the cuboid begins
// to hide its own light, and the next vertex that is looked at lies farther still.
TEST(VisiblePieces, ends_where_a_room_was_too_large) {
  if (test::kSanitized) return;  // a hundred thousand vertices
  const auto system = test::cuboid_over_floor();
  ContourRequest request;
  request.families = {{0}};
  request.measure = Measure::sheet;
  request.levels.values = {0.010316681617751924};
  request.chord_tolerance = 8e-9;
  request.irradiance_tolerance = 1e-9;
  request.caustic = false;
  request.time_limit = 300.0;
  const auto result = trace_contours(system, request);
  int shadowed = 0;
  for (const Curve& curve : result.curves) {
    if (curve.closed || curve.ends[0] != Ending::shadow) continue;
    ++shadowed;
    EXPECT_EQ(curve.ends[1], Ending::occlusion);
    EXPECT_NEAR(curve.length, 1.213615, 1e-5);  // as at a chord of 1e-4
  }
  EXPECT_EQ(shadowed, 1);
}

}  // namespace
}  // namespace caustic::solver
