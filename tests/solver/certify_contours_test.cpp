// Contours with the proof that none is missed.
#include "solver/certify_contours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/dimple.h"
#include "tests/support/sampling.h"
#include "tests/support/scenes.h"
#include "tests/support/thorough.h"

namespace caustic::solver {
namespace {

using namespace geometry;

// The ring of the nephroid: a beam at 45° into a cylinder's arc of ±60°, and the floor.
OpticalSystem nephroid() {
  return test::one_mirror(
      CollimatedLight{Vec3(1, 0, -1).normalized(), 1.0}, make_cylinder({0, 0, 0}, {0, 0, 1}, 1.0),
      test::floor_at({0.5, 0, 0}, 1.2, 1.2), box_aperture({0.5, -1, 0}, {1.001, 1, 1}));
}

ContourRequest levels(std::vector<double> values) {
  ContourRequest request;
  request.levels.values = std::move(values);
  request.certify = true;
  request.time_limit = 60.0;
  return request;
}

TEST(CertifyContours, ProvesTheNephroid) {
  ContourRequest request = levels({1.0, 2.0, 4.0});
  const auto certified = trace_contours(nephroid(), request);
  EXPECT_TRUE(certified.certified);
  EXPECT_EQ(certified.undecided_cells, 0u);
  EXPECT_TRUE(certified.undecided.empty());
  request.certify = false;
  const auto fast = trace_contours(nephroid(), request);
  EXPECT_FALSE(fast.certified);
  EXPECT_FALSE(fast.unproven.empty());
  ASSERT_EQ(certified.curves.size(), fast.curves.size());
  for (std::size_t i = 0; i < fast.curves.size(); ++i) {
    EXPECT_EQ(certified.curves[i].kind, fast.curves[i].kind);
    EXPECT_EQ(certified.curves[i].vertices.size(), fast.curves[i].vertices.size());
    EXPECT_NEAR(certified.curves[i].length, fast.curves[i].length, 1e-9);
  }
}

TEST(CertifyContours, FindsALoopThatTheFastWayMisses) {
  const test::Dimple scene = test::dimple();
  ContourRequest request = levels({1.5});
  request.chord_tolerance = 1e-6;
  request.certify = false;
  const auto fast = trace_contours(scene.system, request);
  EXPECT_FALSE(fast.certified);
  ASSERT_FALSE(fast.unproven.empty());
  EXPECT_NE(fast.unproven[0].find("may be missing"), std::string::npos);
  request.certify = true;
  const auto certified = trace_contours(scene.system, request);
  EXPECT_TRUE(certified.certified) << certified.undecided_cells;
  ASSERT_EQ(certified.curves.size(), fast.curves.size() + 1);
  const auto is_loop = [](const Curve& c) { return c.closed && c.length < 0.01; };
  EXPECT_TRUE(std::none_of(fast.curves.begin(), fast.curves.end(), is_loop));
  const auto loop = std::find_if(certified.curves.begin(), certified.curves.end(), is_loop);
  ASSERT_NE(loop, certified.curves.end());
  // About a thousandth of the receiver wide, around the dimple, on its level.
  EXPECT_GT(loop->length, 0.3e-3 * std::numbers::pi);
  EXPECT_LT(loop->length, 1.2e-3 * std::numbers::pi);
  EXPECT_LT(loop->max_residual, 1e-9);
  for (const CurveVertex& v : loop->vertices) {
    EXPECT_LT(std::hypot(v.x.x() - test::Dimple::kX, v.x.y() - test::Dimple::kY), 2.0 * test::Dimple::kWidth);
  }
}

// Area of what is undecided, m².
double undecided_area(const ContourCertificate& certificate) {
  double area = 0.0;
  for (const UndecidedCell& cell : certificate.undecided) {
    const auto& x = cell.corners;
    area += 0.5 * (x[2] - x[0]).cross(x[3] - x[1]).norm();
  }
  return area;
}

TEST(CertifyContours, UndecidedCellsShrinkWithTheBudget) {
  const OpticalSystem system = nephroid();
  const ForwardMap map(system, 0, -1);
  const Domain domain(map);
  Budget budget(60.0, 1u << 30, nullptr);
  Evaluator evaluate(map, budget);
  const std::vector<LevelFunction> targets{LevelFunction::isolux(2.0, 1), LevelFunction::caustic()};
  double before = kInfinity;
  for (const std::size_t cells : {50u, 100u, 200u, 300u}) {
    const auto certificate = certify_contours(evaluate, domain, targets, {cells});
    EXPECT_TRUE(certificate.exhausted);
    EXPECT_EQ(certificate.cells, cells);
    const double area = undecided_area(certificate);
    EXPECT_LT(area, 0.8 * before) << cells;
    before = area;
  }
  const auto whole = certify_contours(evaluate, domain, targets);
  EXPECT_TRUE(whole.undecided.empty());
  EXPECT_FALSE(whole.exhausted);
}

// At a critical value two branches or a point cannot be told: what is undecided shrinks about the
// critical point with the size of the smallest cells, and is said to be so.
TEST(CertifyContours, CriticalValuesAreUndecided) {
  const auto ball = make_sphere({0, 0, 0}, 1.0);
  const auto system =
      test::one_mirror(PointLight{{0.3, 0.2, 4}, 1.0}, ball, test::floor_at({0, 0, 6}, 12, 12));
  const ForwardMap map(system, 0, 1);
  const Domain domain(map);
  Budget budget(60.0, 1u << 30, nullptr);
  Evaluator evaluate(map, budget);
  // The brightest point: by reflection in the plane through lamp, centre and the receiver's normal
  // it lies in that plane; golden section on the sphere's arc there.
  const Direction across = Vec3(0.3, 0.2, 0).normalized();
  const auto at = [&](double angle) {
    return map.evaluate(Point(std::sin(angle) * across + std::cos(angle) * Vec3::UnitZ()));
  };
  double lo = -0.1, hi = 0.3;
  for (int i = 0; i < 200; ++i) {
    const double a = lo + 0.382 * (hi - lo), b = lo + 0.618 * (hi - lo);
    const bool left = at(a).irradiance() > at(b).irradiance();
    (left ? hi : lo) = left ? b : a;
  }
  const FieldPoint critical = at(0.5 * (lo + hi));
  const std::vector<LevelFunction> targets{{critical.inverse_irradiance()}};
  double before = kInfinity;
  for (const double smallest : {1e-2, 1e-3, 1e-4}) {
    const auto certificate = certify_contours(evaluate, domain, targets, {200000, smallest});
    EXPECT_FALSE(certificate.undecided.empty());
    EXPECT_FALSE(certificate.exhausted);
    const double area = undecided_area(certificate);
    EXPECT_LT(area, 0.1 * before);
    before = area;
    for (const UndecidedCell& cell : certificate.undecided) {
      EXPECT_LT((cell.corners[0] - critical.x).norm(), 20.0 * smallest * system.diameter());
    }
  }
}

constexpr int kChords = test::thorough(600, 60);
constexpr bool kAllMirrors = !test::kSanitized;

// Distance from x to the polyline of a curve on the mirror.
double distance_to(const Curve& curve, const Point& x) {
  double least = kInfinity;
  for (std::size_t i = 0; i + 1 < curve.vertices.size() + curve.closed; ++i) {
    const Point &a = curve.vertices[i].x, &b = curve.vertices[(i + 1) % curve.vertices.size()].x;
    const double w = std::clamp((b - a).dot(x - a) / (b - a).squaredNorm(), 0.0, 1.0);
    least = std::min(least, (a + w * (b - a) - x).norm());
  }
  return least;
}

// Random chords of the mirror: where f changes its sign along one, there is a curve of the answer.
void expect_all_roots_on_curves(const OpticalSystem& system, int side, ContourRequest request,
                                std::uint64_t seed) {
  request.certify = true;
  request.time_limit = 60.0;
  const auto result = trace_contours(system, request);
  EXPECT_TRUE(result.certified) << result.undecided_cells;
  const ForwardMap map(system, 0, side);
  const Domain domain(map);
  test::Random random(seed);
  const Box& region = map.mirror().region;
  const Extent extent{region, region.center(), region.diagonal()};
  int roots = 0;
  for (const Point& from : test::sample_surface(map.shape(), extent, kChords, random)) {
    const Vec3 step = 0.01 * region.diagonal() * random.direction();
    FieldPoint a = map.evaluate(map.project(from));
    for (int n = 1; n <= 10; ++n) {
      const FieldPoint b = map.evaluate(map.project(from + n * step));
      const bool both = domain.contains(a) && domain.contains(b);
      for (std::size_t l = 0; both && l <= 2 * result.levels.size(); ++l) {
        const int parity = l % 2 == 0 ? 1 : -1;
        const bool caustic = l == 2 * result.levels.size();
        const double level = caustic ? -1.0 : result.levels[l / 2];
        const LevelFunction f =
            caustic ? LevelFunction::caustic() : LevelFunction::isolux(level, parity);
        if ((f.value(a) > 0.0) == (f.value(b) > 0.0)) continue;
        Point lo = a.x, hi = b.x;
        const bool rising = f.value(b) > 0.0;
        for (int i = 0; i < 50; ++i) {
          const Point middle = map.project(0.5 * (lo + hi));
          ((f.value(map.evaluate(middle)) > 0.0) == rising ? hi : lo) = middle;
        }
        if (!domain.contains(map.evaluate(lo))) continue;
        ++roots;
        double least = kInfinity;
        for (const Curve& curve : result.curves) {
          const bool same = caustic ? curve.kind == CurveKind::caustic
                                    : curve.level == level && curve.parity == parity;
          if (same) least = std::min(least, distance_to(curve, lo));
        }
        EXPECT_LT(least, 2e-3 * region.diagonal()) << level << " at " << lo.transpose();
      }
      a = b;
    }
  }
  EXPECT_GT(roots, kChords / 20);
}

TEST(CertifyContours, RandomChordsMeetOnlyKnownCurves) {
  ContourRequest five, one, three;
  five.levels.count = 5;
  one.levels.values = {1.0};
  three.levels.values = {1.0, 2.0, 4.0};
  expect_all_roots_on_curves(nephroid(), -1, three, 7403);
  if (!kAllMirrors) return;
  const auto ball = make_sphere({0, 0, 0}, 1.0);
  expect_all_roots_on_curves(
      test::one_mirror(PointLight{{0.3, 0.2, 4}, 1.0}, ball, test::floor_at({0, 0, 6}, 12, 12)), 1,
      five, 7401);
  // A tilted dish: two sheets of caustic, and the aperture's edge. (A sphere's second caustic is a
  // line through its centre, of which the receiver sees a point.)
  const auto dish = make_ellipsoid({0, 0, 1}, {1.0, 1.2, 1.0}, Mat3::Identity());
  expect_all_roots_on_curves(test::one_mirror(CollimatedLight{Vec3(0.2, 0.1, -1).normalized(), 1.0},
                                              dish, test::floor_at({0.1, 0.05, 0.45}, 0.6, 0.6),
                                              {cylinder_aperture({0, 0, 0}, Vec3::UnitZ(), 0.6),
                                               half_space_aperture({0, 0, 0.5}, Vec3::UnitZ())}),
                             -1, one, 7402);
}

// Families that enclosures do not know are named, not passed over.
TEST(CertifyContours, SaysWhatItDoesNotProve) {
  SystemSurface ball = test::mirror(make_sphere({0, 0, 0}, 1.0));
  ball.optics.kind = Optics::Kind::refract;
  ball.optics.index_inside = 1.5;
  const auto system = OpticalSystem::build(PointLight{{0.3, 0.2, 4}, 1.0}, {ball},
                                           test::floor_at({0, 0, -2}, 4, 4));
  ContourRequest request = levels({0.1});
  request.families = {{0, 0}};
  const auto result = trace_contours(system, request);
  EXPECT_FALSE(result.certified);
  ASSERT_EQ(result.unproven.size(), 1u);
  EXPECT_NE(result.unproven[0].find("\"mirror\", \"mirror\""), std::string::npos);
  EXPECT_FALSE(result.curves.empty());
}

}  // namespace
}  // namespace caustic::solver
