// What is proven of totals: sheets over rectangles against a light meter in them, ways against
// visibility, and answers against those without a proof.
#include "solver/certify_total.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "solver/clear_way.h"
#include "solver/contours.h"
#include "solver/enclosed_sheets.h"
#include "solver/family_field.h"
#include "solver/plan.h"
#include "solver/point_irradiance.h"
#include "tests/support/dimple.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"
#include "tests/support/thorough.h"

namespace caustic::solver {
namespace {

using namespace geometry;

constexpr int kRectangles = test::thorough(120, 6);

OpticalSystem bowl() {
  return test::one_mirror(PointLight{{0.3, 0.1, 2.0}, 1.0}, make_sphere({0, 0, 2}, 2.0),
                          ReceiverFrame::make({0, 0, 1.3}, {1, 0, 0}, {0, 1, 0}, {1.2, 1.2}),
                          box_aperture({-0.9, -0.8, -0.1}, {0.9, 0.8, 0.6}));
}

ContourRequest of_total(std::vector<double> values) {
  ContourRequest request;
  request.levels.values = std::move(values);
  request.measure = Measure::total;
  request.time_limit = 60.0;
  return request;
}

// With the proof as without, but proven.
void expect_same_but_proven(const OpticalSystem& system, ContourRequest request) {
  const auto fast = trace_contours(system, request);
  EXPECT_FALSE(fast.certified);
  request.certify = true;
  const auto proven = trace_contours(system, request);
  EXPECT_TRUE(proven.certified) << proven.undecided_cells;
  EXPECT_TRUE(proven.unproven.empty());
  ASSERT_EQ(proven.curves.size(), fast.curves.size());
  for (std::size_t i = 0; i < fast.curves.size(); ++i) {
    EXPECT_EQ(proven.curves[i].kind, fast.curves[i].kind);
    EXPECT_NEAR(proven.curves[i].length, fast.curves[i].length, 1e-6 * fast.curves[i].length);
  }
}

// Every path that the meter finds at a point of a rectangle is one of its sheets, with its E and
// ∇E, or comes from next to a caustic with at least so much; and certain sheets are there.
TEST(CertifyTotal, SheetsOverRectanglesHoldWhatAMeterFinds) {
  const OpticalSystem system = bowl();
  LightMeter meter(system, {{0}}, false);
  const ForwardMap map(system, 0, -1);
  Budget budget(60.0, 1000000, nullptr);
  Evaluator evaluate(map, budget);
  MirrorCells mirror(map, false, budget);
  test::Random random(7);
  int told = 0, near = 0;
  for (int k = 0; k < kRectangles; ++k) {
    const double size = std::pow(10.0, random.uniform(-3.0, -1.0));
    const double u = random.uniform(-0.5, 0.5), v = random.uniform(-0.5, 0.5);
    const ReceiverCell part{{u, u + size}, {v, v + size}};
    const auto over = sheets_over(part, mirror, mirror.all(), size, evaluate);
    if (!over) continue;
    ++told;
    near += !over->near.empty();
    for (int n = 0; n < 4; ++n) {
      const auto at = meter.at({random.uniform(u, u + size), random.uniform(v, v + size)});
      std::vector<int> times(over->sheets.size(), 0);
      for (const auto& path : at.sheets) {
        const auto holds = [&](const EnclosedSheet& s) {
          const auto in = [&](const Interval& w, std::size_t axis) {
            const double x = path.x[static_cast<int>(axis)];
            return w.lo - 1e-12 <= x && x <= w.hi + 1e-12;
          };
          return in(s.cell.s, s.chart.first()) && in(s.cell.t, s.chart.second()) &&
                 in(s.cell.z, s.chart.along());
        };
        const auto sheet = std::find_if(over->sheets.begin(), over->sheets.end(), holds);
        if (sheet == over->sheets.end()) {
          EXPECT_TRUE(std::any_of(over->near.begin(), over->near.end(), [&](const auto& c) {
            return c.least <= path.E && mirror.holds(c.cells, path.x);
          }));
          continue;
        }
        ++times[static_cast<std::size_t>(sheet - over->sheets.begin())];
        const double slack = 1e-9 * path.E;
        EXPECT_LE(sheet->E.lo, path.E + slack);
        EXPECT_GE(sheet->E.hi, path.E - slack);
      }
      for (std::size_t i = 0; i < times.size(); ++i) {
        EXPECT_LE(times[i], 1);
        EXPECT_GE(times[i], over->sheets[i].certain ? 1 : 0);
      }
    }
  }
  EXPECT_GT(told, kRectangles / 3);
  EXPECT_TRUE(near > 0 || test::kSanitized);
}

// No cell that is shown to be clear has a path that is hidden, none that is shown to be hidden has
// another: a mirror that is plane, a ball that light leaves, one that it stays in, each with a
// smaller ball in the way.
TEST(CertifyTotal, PassagesAreThoseOfVisibility) {
  const auto with_a_ball = [](const SystemSurface& mirror, const Point& at) {
    return OpticalSystem::build(PointLight{{0.2, 0.1, 3.0}, 1.0},
                                {mirror, test::absorber(make_sphere(at, 0.25))},
                                test::floor_at({0, 0, 2}, 6, 6));
  };
  const Bound above = half_space_aperture({0, 0, 0}, {0, 0, -1});
  const Bound below = half_space_aperture({0, 0, 2.2}, {0, 0, 1});
  for (const OpticalSystem& system :
       {with_a_ball(
            test::mirror(make_plane({0, 0, 0}, {0, 0, 1}), box_aperture({-1, -1, -1}, {1, 1, 1})),
            {0.1, 0, 0.9}),
        with_a_ball(test::mirror(make_sphere({0, 0, 0}, 1.0), {above}), {0.4, 0, 1.5}),
        with_a_ball(test::mirror(make_sphere({0, 0, 3}, 3.0), {below}), {0.4, 0, 1.2})}) {
    const Plan plan = make_plan(system, {{0}}, false, {});
    ASSERT_FALSE(plan.pieces.empty());
    FamilyField field(system, plan.pieces.front(), nullptr, 1e-2);
    ASSERT_TRUE(field.visibility);
    Budget budget(60.0, 1000000, nullptr);
    Evaluator evaluate(field.map, budget);
    MirrorCells mirror(field.map, true, budget);
    int clear = 0, hidden = 0;
    const ReceiverCell all{{-3.0, 3.0}, {-3.0, 3.0}};
    for (const int i : mirror.reaching(all, mirror.all(), 0.1, budget)) {
      const Passage passage = mirror.passage({i});
      clear += passage == Passage::clear;
      hidden += passage == Passage::hidden;
      const auto box = mirror.box(i);
      const auto f = evaluate.on_surface({box[0].middle(), box[1].middle(), box[2].middle()});
      if (!f.arrives()) continue;
      const bool is_hidden = field.visibility->hidden(field.piece.hops, LightPath(field.map, f));
      EXPECT_NE(passage, is_hidden ? Passage::clear : Passage::hidden) << f.x.transpose();
    }
    EXPECT_GT(clear, 100);
    EXPECT_GT(hidden, 5);
  }
}

// Of a mirrored lamp, of light with a caustic, folds and rims.
TEST(CertifyTotal, ProvesWhatTheFastWayFinds) {
  expect_same_but_proven(
      test::one_mirror(PointLight{{0.1, 0.2, 1.5}, 1.0}, make_plane({0, 0, 0}, {0, 0, 1}),
                       test::floor_at({0, 0, 1}, 2, 2), box_aperture({-1, -1, -1}, {1, 1, 1})),
      of_total({0.05, 0.1, 0.14}));
  if (test::kSanitized) return;  // thousands of rectangles
  expect_same_but_proven(test::one_mirror(CollimatedLight{Vec3(1, 0, -1).normalized(), 1.0},
                                          make_cylinder({0, 0, 0}, {0, 0, 1}, 1.0),
                                          test::floor_at({0.45, 0, 0}, 0.7, 0.7),
                                          box_aperture({0.5, -1, 0}, {1.001, 1, 1})),
                         of_total({2.0}));
}

TEST(CertifyTotal, FindsALoopThatTheFastWayMisses) {
  const test::Dimple scene = test::dimple();
  ContourRequest request = of_total({1.5});
  request.chord_tolerance = 1e-6;
  const auto fast = trace_contours(scene.system, request);
  request.certify = true;
  const auto proven = trace_contours(scene.system, request);
  EXPECT_TRUE(proven.certified) << proven.undecided_cells;
  const auto is_loop = [](const Curve& c) {
    return c.kind == CurveKind::isolux && c.closed && c.length < 0.01;
  };
  EXPECT_TRUE(std::none_of(fast.curves.begin(), fast.curves.end(), is_loop));
  EXPECT_EQ(std::count_if(proven.curves.begin(), proven.curves.end(), is_loop), 1);
}

// The budget leaves rectangles undecided, fewer the larger it is.
TEST(CertifyTotal, UndecidedPartsShrinkWithTheBudget) {
  ContourRequest request = of_total({0.3, 0.5});
  request.certify = true;
  double before = geometry::kInfinity;
  for (const std::size_t cells : {8u, 24u, 72u}) {
    request.cell_limit = cells;
    const auto result = trace_contours(bowl(), request);
    double area = 0.0;
    for (const Undecided& u : result.undecided) {
      if (u.family_id < 0)
        area += (u.corners[1] - u.corners[0]).norm() * (u.corners[3] - u.corners[0]).norm();
    }
    EXPECT_LT(area, 0.8 * before) << cells;
    before = area;
  }
}

}  // namespace
}  // namespace caustic::solver
