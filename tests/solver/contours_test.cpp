// What every trace promises: soundness, completeness, determinism, the chord, scaling; and answers
// where there is nothing to trace.
#include "solver/contours.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>

#include "tests/support/contour_checks.h"
#include "tests/support/distance_to.h"
#include "tests/support/random_scene.h"
#include "tests/support/reference.h"
#include "tests/support/thorough.h"

namespace caustic::solver {
namespace {

using geometry::kPi;
using geometry::Point;
using geometry::ReceiverFrame;
using geometry::Vec2;
using geometry::Vec3;
using test::floor_at;
using test::one_mirror;
using test::Random;

constexpr int kScenes = test::thorough(120, 5), kGrid = test::thorough(50, 20);
constexpr int kStride = test::thorough(23, 101), kShapeStride = test::thorough(1, 4);

bool warned(const ContourResult& r, const std::string& code) {
  for (const Warning& w : r.warnings) {
    if (w.code == code) return true;
  }
  return false;
}

OpticalSystem small_torus(double size = 1.0) {
  return one_mirror(
      PointLight{size * Point(0.4, -0.3, 2.0), size * size},
      geometry::make_torus(Point::Zero(), Vec3(0.1, 0.2, 1.0).normalized(), size * 1.0, size * 0.4),
      floor_at({0, 0, -1.5 * size}, 6 * size, 5 * size));
}

// ---- Soundness
// -----------------------------------------------------------------------------------

TEST(RandomScenes, AreTracedSoundlyAndInTime) {
  for (int seed = 0; seed < kScenes; ++seed) {
    const auto scene = test::random_scene(seed);
    ContourRequest request;
    request.time_limit = 20.0;
    const auto result = trace_contours(scene.system, request);
    EXPECT_TRUE(result.complete) << scene.description;
    test::expect_sound(scene.system, result, 1e-9, scene.description);
    if (HasFailure()) break;
  }
}

TEST(RandomScenes, VerticesAgainstFiftyDigits) {
  Random random(21);
  int checked = 0;
  const auto zoo = test::shape_zoo();
  for (std::size_t k = 0; k < zoo.size(); k += kShapeStride) {
    const test::ShapeSpec& spec = zoo[k];
    test::ReferenceScene reference{
        .shape = spec,
        .side = 1,
        .reflectance = 0.8,
        .light = {},
        .receiver = ReceiverFrame::make(random.in_cube(2.0), random.direction(), random.direction(),
                                        {6, 5})};
    reference.light = CollimatedLight{random.direction(), 2.0};
    if (random.index(2) == 0) reference.light = PointLight{random.in_cube(2.0), 2.0};
    const auto system = OpticalSystem::build(
        reference.light, {test::mirror(test::build(spec), {}, 0.8)}, reference.receiver);
    ContourRequest request;
    request.levels.count = 4;
    for (const Curve& c : trace_contours(system, request).curves) {
      if (c.kind == CurveKind::caustic) continue;
      for (std::size_t i = 1; i + 1 < c.vertices.size(); i += kStride) {
        const Point& x = c.vertices[i].x;
        const auto r = test::reference_field(reference, x);
        // What rounding leaves: of x (S14), which counts most where σ is next to nothing, and of
        // parameters next to apexes and rims.
        if (!geometry::exists_at(system.surfaces()[0].bounds, x, -1e-4)) continue;
        // Second derivatives of a spline are second differences of rounded samples.
        const double roundings = spec.kind == test::ShapeSpec::Kind::heights ? 1e-13 : 1e-14;
        const double conditioning =
            roundings * ((1.0 + r.curvature) * (r.scale_of_a + r.grad_a.norm()) / std::abs(r.a) +
                         r.grad_flux.norm() / std::abs(r.flux));
        // Negative where the light is on the other side, for which the reference was not asked.
        EXPECT_NEAR(std::abs(test::reference_irradiance(reference, x)) / c.level, 1.0,
                    1e-9 + conditioning)
            << spec.name;
        ++checked;
      }
    }
  }
  EXPECT_GT(checked, 4000 / (kStride * kShapeStride));
}

// ---- The chord
// -----------------------------------------------------------------------------------

TEST(Chord, PolylinesStayWithinTheTolerance) {
  int curves = 0;
  for (int seed = 0; seed < kScenes / 2; ++seed) {
    const auto scene = test::random_scene(seed);
    if (scene.system.surfaces().size() > 1) continue;
    for (const double share : {1e-2, 1e-4}) {
      ContourRequest request;
      request.chord_tolerance = share * scene.system.receiver().width();
      request.levels.count = 3;
      for (const Curve& c : trace_contours(scene.system, request).curves) {
        EXPECT_LE(test::largest_chord_error(scene.system, c), 1.0001 * request.chord_tolerance)
            << scene.description << " level " << c.level << " parity " << c.parity << " n "
            << c.vertices.size();
        ++curves;
      }
    }
  }
  EXPECT_GT(curves, kScenes / 2);
}

// ---- Determinism
// ---------------------------------------------------------------------------------

void expect_identical(const ContourResult& a, const ContourResult& b) {
  ASSERT_EQ(a.curves.size(), b.curves.size());
  EXPECT_EQ(a.evaluations, b.evaluations);
  EXPECT_EQ(a.levels, b.levels);
  for (std::size_t i = 0; i < a.curves.size(); ++i) {
    const Curve &p = a.curves[i], &q = b.curves[i];
    EXPECT_EQ(p.ends, q.ends);
    EXPECT_EQ(p.closed, q.closed);
    ASSERT_EQ(p.vertices.size(), q.vertices.size());
    for (std::size_t k = 0; k < p.vertices.size(); ++k) {
      const CurveVertex &v = p.vertices[k], &w = q.vertices[k];
      EXPECT_TRUE(v.uv == w.uv && v.p == w.p && v.x == w.x && v.irradiance == w.irradiance &&
                  v.residual == w.residual && v.gradient == w.gradient &&
                  v.arc_length == w.arc_length);
    }
  }
}

TEST(Determinism, ThreadsAndRepetitionChangeNothing) {
  for (int seed = 0; seed < kScenes / 5; ++seed) {
    const auto scene = test::random_scene(seed);
    ContourRequest request;
    request.time_limit = 60.0;
    const auto once = trace_contours(scene.system, request);
    expect_identical(once, trace_contours(scene.system, request));
    request.threads = 3;
    expect_identical(once, trace_contours(scene.system, request));
  }
}

// ---- Scale
// ---------------------------------------------------------------------------------------

TEST(Scale, ScaledScenesGiveScaledCurves) {
  ContourRequest request;
  request.levels.values = {0.01, 0.02, 0.04, 0.08};
  const auto unit = trace_contours(small_torus(), request);
  EXPECT_GT(unit.curves.size(), 4u);
  for (const double size : {1e-6, 1e6}) {
    // Intensity goes with the square, so that irradiance stays.
    const auto result = trace_contours(small_torus(size), request);
    test::expect_sound(small_torus(size), result, 1e-9, "scaled torus");
    ASSERT_EQ(result.curves.size(), unit.curves.size());
    for (std::size_t i = 0; i < unit.curves.size(); ++i) {
      const Curve &a = unit.curves[i], &b = result.curves[i];
      EXPECT_EQ(a.level, b.level);
      EXPECT_EQ(a.closed, b.closed);
      EXPECT_EQ(a.ends, b.ends);
      EXPECT_NEAR(b.length / size, a.length, 1e-3 * a.length);
    }
  }
}

// ---- Completeness
// --------------------------------------------------------------------------------

// Every place where a fine grid on the mirror crosses a level must lie on a traced curve of that
// level and parity.
TEST(Completeness, NothingThatAFineGridShowsIsMissing) {
  int places = 0;
  for (int seed = 0; seed < kScenes; ++seed) {
    const auto scene = test::random_scene(50000 + seed);
    ContourRequest request;
    request.levels.count = 4;
    const auto result = trace_contours(scene.system, request);
    // Of a constant field rounding alone makes grids show levels.
    if (warned(result, "uniform_irradiance")) continue;
    for (const FamilyReport& family : result.families) {
      for (const int side : {1, -1}) {
        for (const int parity : {1, -1}) {
          for (const double level : result.levels) {
            const auto grid =
                test::points_on_grid(scene.system, family.surfaces[0], side, level, parity, kGrid);
            int missed = 0;
            Vec2 example = Vec2::Zero();
            for (const FieldPoint& f : grid) {
              double least = geometry::kInfinity;
              for (const Curve& c : result.curves) {
                if (c.level != level || c.parity != parity || c.family_id != family.id) continue;
                least = std::min(least, test::distance_to(c, f.q));
              }
              ++places;
              if (least > 1.5e-4 * scene.system.receiver().width()) ++missed, example = f.q;
            }
            EXPECT_EQ(missed, 0) << scene.description << ", family " << family.id << " side "
                                 << side << " level " << level << " parity " << parity << ": of "
                                 << grid.size() << ", such as " << example.transpose();
          }
        }
      }
    }
  }
  EXPECT_GT(places, 8 * kScenes);
}

// ---- Nothing to trace, or too much
// ---------------------------------------------------------------

// Answers within the limits with finite numbers; returns the result.
ContourResult answer(const OpticalSystem& system, const std::string& what,
                     std::vector<double> levels = {}) {
  ContourRequest request;
  request.levels.values = std::move(levels);
  const auto begin = std::chrono::steady_clock::now();
  ContourResult result = trace_contours(system, request);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  EXPECT_LT(seconds.count(), request.time_limit + 1.0) << what;
  EXPECT_TRUE(std::isfinite(result.families[0].flux)) << what;
  for (const double level : result.levels) EXPECT_TRUE(std::isfinite(level) && level > 0.0) << what;
  for (const Curve& c : result.curves) {
    EXPECT_GE(c.vertices.size(), 2u) << what;
    EXPECT_TRUE(std::isfinite(c.length) && std::isfinite(c.max_residual)) << what;
    for (const CurveVertex& v : c.vertices) {
      EXPECT_TRUE(v.uv.allFinite() && v.p.allFinite() && v.x.allFinite() &&
                  std::isfinite(v.irradiance) && std::isfinite(v.residual) &&
                  v.gradient.allFinite() && std::isfinite(v.arc_length))
          << what;
    }
  }
  return result;
}

// The same, and every curve holds what every curve promises.
ContourResult sound_answer(const OpticalSystem& system, const std::string& what,
                           std::vector<double> levels = {}) {
  ContourResult result = answer(system, what, std::move(levels));
  test::expect_sound(system, result, 1e-9, what);
  return result;
}

TEST(Degenerate, EllipsoidFromFocusToFocus) {
  const double a = 2.0, b = 1.2, c = std::sqrt(a * a - b * b);
  const auto shape = geometry::make_ellipsoid(Point::Zero(), {a, b, b}, geometry::Mat3::Identity());
  for (const Vec3& u : {Vec3(0, 1, 0), Vec3(1, 1, 0), Vec3(1, 0.2, 0)}) {
    const auto receiver = ReceiverFrame::make({c, 0, 0}, u, {0, 0, 1}, {1, 1});
    const auto result = answer(one_mirror(PointLight{{-c, 0, 0}, 1.0}, shape, receiver), "foci");
    EXPECT_TRUE(result.complete);
    EXPECT_TRUE(result.curves.empty());
    EXPECT_TRUE(warned(result, "degenerate_family"));
    if (test::kSanitized) break;
  }
  // Nearly: the light 1e-9 off the focus.
  answer(one_mirror(PointLight{{-c + 1e-9, 0, 0}, 1.0}, shape,
                    ReceiverFrame::make({c, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1})),
         "near focus");
}

TEST(Degenerate, ParaboloidFocusesABeam) {
  const auto shape = geometry::make_conic(Point::Zero(), {0, 0, 1}, 2.0, -1.0, {});
  const auto result =
      answer(one_mirror(CollimatedLight{{0, 0, -1}, 1.0}, shape, floor_at({0, 0, 1}, 1, 1),
                        {geometry::cylinder_aperture(Point::Zero(), {0, 0, 1}, 1.0)}),
             "focused beam");
  EXPECT_TRUE(result.complete);
  EXPECT_TRUE(result.curves.empty());
  EXPECT_TRUE(warned(result, "degenerate_family"));
}

TEST(Degenerate, CylinderFocusesIntoALine) {
  // A parabolic trough: all light goes through a line of the receiver.
  const auto trough = geometry::make_quadric({1, 0, 0, 0, 0, 0, 0, 0, -2.0, 0}, {}).surface;
  const auto result =
      answer(one_mirror(CollimatedLight{{0, 0, -1}, 1.0}, trough, floor_at({0, 0, 1}, 1, 1),
                        geometry::box_aperture({-1, -1, -1}, {1, 1, 1})),
             "trough");
  EXPECT_TRUE(result.complete);
  EXPECT_TRUE(warned(result, "degenerate_family"));
}

TEST(Degenerate, UniformIrradiance) {
  const auto result =
      answer(one_mirror(CollimatedLight{Vec3(0.3, 0, -1).normalized(), 2.0},
                        geometry::make_plane(Point::Zero(), {0, 0, 1}), floor_at({0, 0, 3}, 2, 2)),
             "uniform");
  EXPECT_TRUE(result.complete);
  EXPECT_TRUE(result.curves.empty());
  EXPECT_TRUE(warned(result, "uniform_irradiance"));
}

TEST(Degenerate, LightOnAMirror) {
  const auto receiver = floor_at({0, 0, 3}, 4, 4);
  // So near that rounding of the mirror's points makes up much of the light's distance, all that
  // can be asked is an answer.
  for (std::size_t k = 0; k < 5; k += kShapeStride) {
    const double height = std::array{1e-9, 0.0, 1e-14, -1e-9, 1e-3}[k];
    answer(one_mirror(PointLight{{0, 0, 1 + height}, 1.0},
                      geometry::make_sphere(Point::Zero(), 1.0), receiver),
           "on a sphere " + std::to_string(height));
    answer(one_mirror(PointLight{{0.2, 0.1, height}, 1.0},
                      geometry::make_plane(Point::Zero(), {0, 0, 1}), receiver),
           "on a plane " + std::to_string(height));
    answer(
        one_mirror(PointLight{{1.0 + height, 0, 0.5}, 1.0},
                   geometry::make_cylinder(Point::Zero(), {0, 0, 1}, 1.0),
                   floor_at(Point::Zero(), 3, 3), geometry::box_aperture({-2, -2, 0}, {2, 2, 1})),
        "on a cylinder " + std::to_string(height));
  }
}

TEST(Degenerate, LightInsideAMirror) {
  const auto sphere = geometry::make_sphere(Point::Zero(), 1.0);
  // Receiver outside: the sphere itself hides it.
  const auto outside = sound_answer(
      one_mirror(PointLight{{0.3, 0, 0}, 1.0}, sphere, floor_at({0, 0, 3}, 4, 4)), "closed");
  EXPECT_TRUE(outside.curves.empty());
  EXPECT_TRUE(warned(outside, "unlit_family"));
  const auto inside = sound_answer(
      one_mirror(PointLight{{0.3, 0, 0.2}, 1.0}, sphere, floor_at({0, 0, -0.3}, 1, 1)), "inside");
  EXPECT_FALSE(inside.curves.empty());
  // At the centre every ray comes back: E is a point's again.
  answer(one_mirror(PointLight{Point::Zero(), 1.0}, sphere, floor_at({0, 0, -0.3}, 1, 1)),
         "centre");
  answer(one_mirror(PointLight{Point::Zero(), 1.0}, sphere, floor_at(Point::Zero(), 1, 1)),
         "centre on the receiver");
}

TEST(Degenerate, RaysAlongAPlane) {
  const auto plane = geometry::make_plane(Point::Zero(), {0, 0, 1});
  for (const double rise : {0.0, 1e-15, -1e-15, 1e-8}) {
    const auto result =
        answer(one_mirror(CollimatedLight{Vec3(1, 0, rise).normalized(), 1.0}, plane,
                          ReceiverFrame::make({3, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 2})),
               "grazing");
    EXPECT_TRUE(result.complete);
    EXPECT_TRUE(result.curves.empty());
  }
  // A receiver in the mirror's plane, and one that the rays run along.
  answer(one_mirror(PointLight{{0, 0, 1}, 1.0}, plane, floor_at(Point::Zero(), 2, 2)), "coplanar");
  answer(one_mirror(CollimatedLight{{0, 0, -1}, 1.0}, plane,
                    ReceiverFrame::make({0, 0, 2}, {1, 0, 0}, {0, 0, 1}, {2, 2})),
         "edge on");
}

TEST(Degenerate, NothingReachesTheReceiver) {
  const auto below =
      answer(one_mirror(PointLight{{0, 0, 4}, 1.0}, geometry::make_sphere(Point::Zero(), 1.0),
                        floor_at({0, 0, -3}, 1, 1)),
             "out of reach");
  EXPECT_TRUE(below.curves.empty());
  EXPECT_TRUE(warned(below, "unlit_family"));
  EXPECT_TRUE(below.complete);
  // An aperture that admits nothing.
  const auto empty =
      answer(one_mirror(PointLight{{0, 0, 4}, 1.0}, geometry::make_sphere(Point::Zero(), 1.0),
                        floor_at({0, 0, 6}, 4, 4), geometry::box_aperture({5, 5, 5}, {6, 6, 6})),
             "empty aperture");
  EXPECT_TRUE(empty.curves.empty());
  EXPECT_TRUE(warned(empty, "unlit_family"));
  // Hidden by a screen.
  const auto hidden =
      OpticalSystem::build(PointLight{{0, 0, 4}, 1.0},
                           {test::mirror(geometry::make_sphere(Point::Zero(), 1.0)),
                            test::absorber(geometry::make_plane({0, 0, 2}, {0, 0, 1}))},
                           floor_at({0, 0, 6}, 4, 4));
  const auto result = answer(hidden, "screen");
  EXPECT_TRUE(result.curves.empty());
}

TEST(Degenerate, LevelAtACriticalPoint) {
  // The brightest point of case A1 is on the axis.
  const auto system =
      one_mirror(PointLight{{0, 0, 4}, 1.0}, geometry::make_sphere(Point::Zero(), 1.0),
                 floor_at({0, 0, 6}, 12, 12));
  const double top = ForwardMap(system, 0, 1).evaluate({0, 0, 1}).irradiance();
  for (const double share : {1.0, 1.0 + 1e-15, 1.0 - 1e-15, 1.0 - 1e-12, 1.0 - 1e-9, 1.0 + 1e-9}) {
    const auto result = sound_answer(system, "critical level", {share * top});
    EXPECT_TRUE(result.complete);
    EXPECT_LE(result.curves.size(), 1u);
  }
  EXPECT_TRUE(warned(answer(system, "critical level", {top}), "critical_level"));
  const auto just_below = sound_answer(system, "just below", {top * (1.0 - 1e-6)});
  EXPECT_EQ(just_below.curves.size(), 1u);
  EXPECT_TRUE(answer(system, "above", {2.0 * top}).curves.empty());
  EXPECT_TRUE(answer(system, "extreme", {1e-300, 1e300}).curves.empty());
}

TEST(Degenerate, OverflowingFlux) {
  const auto sphere = geometry::make_sphere(Point::Zero(), 1.0);
  for (const double intensity : {1e300, 1e-300}) {
    answer(one_mirror(PointLight{{0, 0, 4}, intensity}, sphere, floor_at({0, 0, 6}, 4, 4)),
           "intensity");
  }
  answer(one_mirror(PointLight{{0, 0, 1e-160}, 1.0}, geometry::make_plane(Point::Zero(), {0, 0, 1}),
                    floor_at({0, 0, 3}, 4, 4)),
         "near a plane");
}

TEST(Limits, CutTheWorkShort) {
  const auto system = small_torus();
  ContourRequest request;
  request.chord_tolerance = 1e-7;
  request.vertex_limit = 500;
  const auto few = trace_contours(system, request);
  EXPECT_FALSE(few.complete);
  EXPECT_TRUE(warned(few, "limit"));
  std::size_t vertices = 0;
  for (const Curve& c : few.curves) {
    vertices += c.vertices.size();
    EXPECT_EQ(c.ends.size(), c.closed ? 0u : 2u);
  }
  EXPECT_LT(vertices, 1000u);

  request.vertex_limit = 500000;
  request.time_limit = 1e-3;
  const auto begin = std::chrono::steady_clock::now();
  const auto brief = trace_contours(system, request);
  EXPECT_FALSE(brief.complete);
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 1.0);

  request.time_limit = 60.0;
  std::atomic<bool> cancelled{true};
  request.cancelled = &cancelled;
  EXPECT_FALSE(trace_contours(system, request).complete);
}

}  // namespace
}  // namespace caustic::solver
