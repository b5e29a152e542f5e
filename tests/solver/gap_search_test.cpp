// What is hidden and what shows of a whole family: brute force against the solver.
#include "solver/gap_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "tests/support/scenes.h"

namespace caustic::solver {
namespace {

using geometry::kPi;
using test::floor_at;

struct Ball {
  Point center;
  double radius;
  std::optional<double> hit(const Point& o, const Vec3& w) const {  // |w| = 1, from outside
    const Vec3 oc = o - center;
    const double b = oc.dot(w), radicand = b * b - oc.squaredNorm() + radius * radius;
    const double t = -b - std::sqrt(std::max(radicand, 0.0));
    return radicand > 0.0 && t > 1e-9 ? std::optional(t) : std::nullopt;
  }
  Vec3 reflect(const Point& y, const Vec3& w) const {
    const Vec3 n = (y - center) / radius;
    return w - 2.0 * w.dot(n) * n;
  }
};

// The example of two mirrors: what goes over the large ball to the small one and on to the floor
// would have to pass the small one before.
TEST(GapSearch, FamilyInItsOwnShadowBringsNothing) {
  const Point lamp(-3, 0, 3);
  const Ball large{{0.5, 0, 1}, 1.0}, small{{-0.9, 0.35, 1.6}, 0.35};
  const Vec3 axis = large.center - lamp;
  const double away = axis.norm(), least = std::sqrt(1.0 - 1.0 / (away * away));
  const geometry::Frame frame(axis / away);
  int arrive = 0, shown = 0;
  constexpr int kRings = 300, kRays = 600;
  for (int k = 0; k < kRings * kRays; ++k) {
    const double cosine = 1.0 - (1.0 - least) * (k / kRays + 0.5) / kRings;
    const double sine = std::sqrt(1.0 - cosine * cosine), phi = 2.0 * kPi * (k % kRays) / kRays;
    Vec3 w = cosine * axis / away + sine * (std::cos(phi) * frame.e1 + std::sin(phi) * frame.e2);
    const auto first = large.hit(lamp, w);
    if (!first) continue;
    const bool shadowed = small.hit(lamp, w).has_value();
    Point y = lamp + *first * w;
    w = large.reflect(y, w);
    const auto second = small.hit(y, w);
    if (!second) continue;
    y += *second * w;
    w = small.reflect(y, w);
    const Point p = y - y.z() / w.z() * w;
    if (w.z() >= 0.0 || std::abs(p.x()) > 5.0 || std::abs(p.y()) > 5.0) continue;
    ++arrive;
    shown += !shadowed && !large.hit(y, w);
  }
  ASSERT_GT(arrive, 100);
  ASSERT_EQ(shown, 0);

  auto first = test::mirror(geometry::make_sphere(large.center, large.radius));
  auto second = test::mirror(geometry::make_sphere(small.center, small.radius), {}, 0.8);
  second.name = "small";
  const auto system =
      OpticalSystem::build(PointLight{lamp, 1.0}, {first, second}, floor_at({0, 0, 0}, 10, 10));
  ContourRequest request;
  request.families = {{0, 1}};
  const auto result = trace_contours(system, request);
  EXPECT_EQ(result.families[0].flux, 0.0);
  EXPECT_TRUE(result.curves.empty());
  EXPECT_EQ(result.undecided_cells, 0u);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_EQ(result.warnings[0].code, "unlit_family");
}

// A mirror lit through a slit that falls between all samples: the curves that show are those of the
// slit's image, which is as wide as the slit is twice.
TEST(GapSearch, SlitBetweenSamplesIsFound) {
  constexpr double kMiddle = 0.0371, kWidth = 0.008;
  std::vector<SystemSurface> surfaces{test::mirror(
      geometry::make_plane({0, 0, 0}, {0, 0, 1}), geometry::box_aperture({-1, -1, -1}, {1, 1, 1}))};
  const auto blade = [&](double from, double to) {
    surfaces.push_back(test::absorber(geometry::make_plane({0, 0, 1}, {0, 0, 1}),
                                      geometry::box_aperture({from, -9, 0}, {to, 9, 2})));
    surfaces.back().name += std::to_string(surfaces.size());
  };
  blade(-9, kMiddle - kWidth / 2);
  blade(kMiddle + kWidth / 2, 9);
  // Light returns below the blades, onto a screen upright beside the mirror.
  const auto screen =
      geometry::ReceiverFrame::make({0, 1.5, 0.5}, {1, 0, 0}, {0, 0, 1}, {4.0, 0.9});
  const auto system =
      OpticalSystem::build(PointLight{{0, -2, 2}, 1.0}, std::move(surfaces), screen);
  ContourRequest request;
  request.levels.values = {0.04, 0.043, 0.046};
  const auto result = trace_contours(system, request);
  ASSERT_EQ(result.curves.size(), 3u);  // one of each level
  for (const Curve& c : result.curves) {
    EXPECT_EQ(c.ends.size(), 2u);
    for (const Ending end : c.ends)
      EXPECT_TRUE(end == Ending::shadow || end == Ending::receiver_edge);
    for (const CurveVertex& v : c.vertices) {
      // Twice as far from the lamp's height as the blades are.
      EXPECT_LE(std::abs(v.x.x() - 2.0 * kMiddle), kWidth * (1.0 + 1e-9));
    }
  }
}

}  // namespace
}  // namespace caustic::solver
