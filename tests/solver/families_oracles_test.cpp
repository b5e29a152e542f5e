// Families with known answers: caustics under water, and the two places on later surfaces where a →
// ∞, grazing incidence and total internal reflection, which no sign of a may be read from.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "geometry/expression/field.h"
#include "solver/contours.h"
#include "solver/point_irradiance.h"
#include "tests/support/scenes.h"

namespace caustic::solver {
namespace {

using geometry::kPi;
using test::floor_at;

constexpr double kWaterIndex = 1.33;

SystemSurface water(geometry::SurfacePtr shape) {
  SystemSurface surface = test::mirror(std::move(shape));
  surface.name = "water";
  surface.optics = {
      .kind = Optics::Kind::refract, .index_outside = 1.0, .index_inside = kWaterIndex};
  return surface;
}

geometry::SurfacePtr expression(const char* text, const Point& min, const Point& max) {
  return geometry::make_expression(geometry::read_expression(text, 1.0), {min, max}, {}).surface;
}

// Where a vertical ray that meets z = 0.1 sin 2πx at x arrives on z = −1, by Snell's law in the
// plane.
long double arrival_under_waves(long double x) {
  const long double k = 2.0L * std::acos(-1.0L), slope = 0.1L * k * std::cos(k * x);
  const long double eta = 1.0L / static_cast<long double>(kWaterIndex);
  const long double c = 1.0L / std::sqrt(1.0L + slope * slope), nx = -slope * c, nz = c;
  const long double bend = eta * c - std::sqrt(1.0L - eta * eta * (1.0L - c * c));
  const long double tx = bend * nx, tz = -eta + bend * nz;
  return x - tx / tz * (1.0L + 0.1L * std::sin(k * x));
}

// dX/dx to fourth order.
long double slope_under_waves(long double x) {
  const long double h = 1e-4L;
  return (8.0L * (arrival_under_waves(x + h) - arrival_under_waves(x - h)) -
          (arrival_under_waves(x + 2.0L * h) - arrival_under_waves(x - 2.0L * h))) /
         (12.0L * h);
}

// Light turns back where dX/dx = 0: straight caustics across the floor.
TEST(Refraction, CausticsUnderSinusoidalWaves) {
  const auto system =
      OpticalSystem::build(CollimatedLight{{0, 0, -1}, 1.0},
                           {water(expression("z-0.1*sin(2*pi*x)", {-1, -1, -0.2}, {2, 2, 0.2}))},
                           floor_at({0.5, 0.5, -1}, 1, 1));
  std::map<double, int> expected;
  for (int i = -1000; i < 2000; ++i) {
    long double lo = i / 1000.0L, hi = (i + 1) / 1000.0L;
    if (slope_under_waves(lo) * slope_under_waves(hi) > 0.0L) continue;
    for (int k = 0; k < 60; ++k) {
      const long double middle = 0.5L * (lo + hi);
      (slope_under_waves(lo) * slope_under_waves(middle) > 0.0L ? lo : hi) = middle;
    }
    const double u = static_cast<double>(arrival_under_waves(lo)) - 0.5;
    if (std::abs(u) < 0.5) expected[u] = 0;
  }
  ASSERT_EQ(expected.size(), 2u);
  ContourRequest request;
  request.isolux = false;
  for (const Curve& c : trace_contours(system, request).curves) {
    ASSERT_EQ(c.kind, CurveKind::caustic);
    EXPECT_NEAR(c.length, 1.0, 1e-9);
    const auto nearest =
        std::min_element(expected.begin(), expected.end(), [&](const auto& a, const auto& b) {
          return std::abs(a.first - c.vertices[0].uv.x()) <
                 std::abs(b.first - c.vertices[0].uv.x());
        });
    for (const CurveVertex& v : c.vertices) EXPECT_NEAR(v.uv.x(), nearest->first, 1e-9);
    ++nearest->second;
  }
  for (const auto& [u, count] : expected) EXPECT_EQ(count, 1) << u;
}

// A plane mirror before a ball is a mirrored lamp over the ball: the ball's silhouette, where the
// second hop grazes, lies within the receiver. A convex mirror has no caustic.
struct MirroredLamp {
  static constexpr double kMirror = -1.0;  // height of the plane
  Point lamp{-1.5, 0.3, 1.0};
  SystemSurface ball = test::mirror(geometry::make_sphere({0, 0, 1.2}, 0.8));
  SystemSurface plane = test::mirror(geometry::make_plane({0, 0, kMirror}, {0, 0, 1}),
                                     geometry::box_aperture({-4, -4, -2}, {4, 4, 0}));
  geometry::ReceiverFrame receiver = floor_at({0, 0, 5.0}, 14, 14);
  OpticalSystem system = OpticalSystem::build(PointLight{lamp, 1.0}, {plane, ball}, receiver);
  OpticalSystem alone = OpticalSystem::build(
      PointLight{{lamp.x(), lamp.y(), 2.0 * kMirror - lamp.z()}, 1.0}, {ball}, receiver);
};

struct Drawn {
  int curves = 0, closed = 0;
  double length = 0.0;
};
std::map<double, Drawn> drawn(const ContourResult& result) {
  std::map<double, Drawn> by_level;
  for (const Curve& c : result.curves) {
    Drawn& level = by_level[c.level];
    ++level.curves;
    level.closed += c.closed;
    level.length += c.length;
  }
  return by_level;
}

TEST(Families, GrazingOnALaterSurfaceIsNoChangeOfSign) {
  const MirroredLamp scene;
  ContourRequest request;
  request.families = {{0, 1}};
  request.levels.count = 8;
  const auto result = trace_contours(scene.system, request);
  EXPECT_EQ(result.undecided_cells, 0u);
  for (const auto& w : result.warnings) ADD_FAILURE() << w.code << ": " << w.detail;
  LightMeter meter(scene.alone, {}, false);
  int vertices = 0;
  for (const Curve& c : result.curves) {
    EXPECT_EQ(c.kind, CurveKind::isolux) << "a caustic of a convex mirror";
    for (std::size_t i = 0; i < c.vertices.size(); i += 5) {
      EXPECT_NEAR(meter.at(c.vertices[i].uv).E / c.level, 1.0, 1e-8);
      ++vertices;
    }
  }
  EXPECT_GT(vertices, 50);

  // The same curves as those of the mirrored lamp, each of them once.
  request.families.clear();
  request.levels.values = result.levels;
  const auto expected = drawn(trace_contours(scene.alone, request)), found = drawn(result);
  ASSERT_EQ(found.size(), expected.size());
  for (const auto& [level, e] : expected) {
    ASSERT_TRUE(found.contains(level)) << level;
    const Drawn& f = found.at(level);
    EXPECT_EQ(f.curves, e.curves) << level;
    EXPECT_EQ(f.closed, e.closed) << level;
    EXPECT_NEAR(f.length, e.length, 1e-3 * e.length) << level;
  }
}

// Where E is a thousandth of what is usual the first hit is within its rounding of the end of all
// paths. The curve is found, whole, once; what its place is worth is said, and true.
TEST(Families, LowLevelsNextToGrazingSayWhatTheyAreWorth) {
  const MirroredLamp scene;
  ContourRequest request;
  request.families = {{0, 1}};
  request.levels.values = {2e-6};
  const auto result = trace_contours(scene.system, request);
  EXPECT_EQ(result.undecided_cells, 0u);
  ASSERT_EQ(result.curves.size(), 1u);
  const Curve& c = result.curves[0];
  EXPECT_TRUE(c.closed);
  LightMeter meter(scene.alone, {}, false);
  for (std::size_t i = 0; i < c.vertices.size(); i += 50) {
    const CurveVertex& v = c.vertices[i];
    EXPECT_NEAR(meter.at(v.uv).E / c.level, 1.0, v.residual + 1e-10);
    EXPECT_LT(v.residual, 1e-6);
  }
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_EQ(result.warnings[0].code, "conditioning");
}

// A lamp under water: at the critical angle rays leave along the surface. Levels are circles about
// the lamp's foot, and E falls outwards, so there is one of each and no caustic.
TEST(Refraction, TotalInternalReflectionIsNoChangeOfSign) {
  const auto system = OpticalSystem::build(PointLight{{0.4, -0.3, -1.0}, 1.0},
                                           {water(geometry::make_plane(Point::Zero(), {0, 0, 1}))},
                                           floor_at({0, 0, 0.05}, 5, 5));
  ContourRequest request;
  request.levels.count = 10;
  const auto result = trace_contours(system, request);
  EXPECT_EQ(result.undecided_cells, 0u);
  for (const auto& w : result.warnings) ADD_FAILURE() << w.code << ": " << w.detail;
  std::map<double, int> closed;
  double before = geometry::kInfinity;
  for (const Curve& c : result.curves) {
    EXPECT_EQ(c.kind, CurveKind::isolux);
    const Vec2 foot(0.4, -0.3);
    const double radius = (c.vertices[0].uv - foot).norm();
    for (const CurveVertex& v : c.vertices) EXPECT_NEAR((v.uv - foot).norm(), radius, 1e-8);
    if (c.closed) ++closed[c.level];
    EXPECT_LE(radius, before * (1.0 + 1e-9));  // curves come by ascending level
    before = radius;
  }
  for (const auto& [level, count] : closed) EXPECT_EQ(count, 1) << level;
  EXPECT_GE(closed.size(), 5u);
}

// Chen's vase with the lamp in the plane y = 0: all curves have a mirror image, and where levels
// run along the window's edge none is lost.
TEST(Families, VaseIsItsOwnMirrorImage) {
  const auto vase = test::mirror(
      geometry::make_revolution({0, 0, 0}, {0, 0, 1}, 2.0, {0.47, 3.90, -9.78, 5.80}).surface);
  const auto system =
      OpticalSystem::build(PointLight{{3, 0, 3}, 1.0}, {vase}, floor_at({0, 0, -0.5}, 10, 10));
  ContourRequest request;
  // The second touches the edge nearly.
  request.levels.values = {7.84e-5, 1.2011786763719087e-4, 4.3e-4};
  const auto result = trace_contours(system, request);
  EXPECT_EQ(result.undecided_cells, 0u);
  for (const auto& w : result.warnings) ADD_FAILURE() << w.code << ": " << w.detail;
  const auto upper = [](const Curve& c, double sign) {
    double most = -geometry::kInfinity;
    for (const CurveVertex& v : c.vertices) most = std::max(most, sign * v.uv.y());
    return most;
  };
  for (const Curve& c : result.curves) {
    const auto images =
        std::count_if(result.curves.begin(), result.curves.end(), [&](const Curve& o) {
          return o.kind == c.kind && o.level == c.level && o.parity == c.parity &&
                 std::abs(o.length - c.length) < 1e-3 * c.length + 1e-4 &&
                 std::abs(upper(o, -1.0) - upper(c, 1.0)) < 1e-3 &&
                 std::abs(upper(o, 1.0) - upper(c, -1.0)) < 1e-3;
        });
    EXPECT_EQ(images, 1) << to_string(c.kind) << " " << c.level << " " << c.length;
  }
  EXPECT_GT(result.curves.size(), 10u);
}

// Regions with one and with three paths from the light to the plane ([MH] Plate 4).
TEST(Paths, OfTheCuboidAreOneOrThree) {
  const auto cuboid =
      test::mirror(expression("x^4+y^4+z^4-x^2-y^2-z^2", {-1.3, -1.3, -1.3}, {1.3, 1.3, 1.3}));
  const auto system =
      OpticalSystem::build(PointLight{{3, 1.5, 3}, 1.0}, {cuboid}, floor_at({0, 0, -1.3}, 10, 10));
  LightMeter meter(system, {}, false);
  std::map<std::size_t, int> counts;
  constexpr int kSide = 24;
  for (int i = 0; i < kSide * kSide; ++i) {
    const Vec2 q(10.0 * ((i % kSide + 0.5) / kSide - 0.5),
                 10.0 * ((i / kSide + 0.5) / kSide - 0.5));
    ++counts[meter.at(q).sheets.size()];
  }
  EXPECT_GT(counts[1], 20);
  EXPECT_GT(counts[3], 20);
}

}  // namespace
}  // namespace caustic::solver
