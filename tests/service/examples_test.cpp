// Every example is traced, soundly and to the end, and passes all places that a grid on its mirrors
// shows.
#include "service/examples/examples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "service/api/contour_json.h"
#include "tests/support/contour_checks.h"
#include "tests/support/distance_to.h"
#include "tests/support/sheet_grid.h"
#include "tests/support/thorough.h"
#include "tests/support/total_checks.h"

namespace caustic::service {
namespace {

using geometry::Vec2;
using solver::ContourResult;
using solver::Curve;

constexpr int kGrid = test::thorough(60, 20), kHopGrid = test::thorough(36, 12);

void expect_complete(const solver::OpticalSystem& system, const ContourResult& result,
                     double within) {
  std::size_t places_seen = 0, families_checked = 0;
  for (const auto& family : result.families) {
    const int surface = family.surfaces[0];
    if (family.surfaces.size() > 1) continue;
    ++families_checked;
    for (std::size_t i = 0; i < result.levels.size(); i += 3) {
      for (const int side : {1, -1}) {
        for (const int parity : {1, -1}) {
          const double level = result.levels[i];
          int missed = 0;
          const auto places = test::points_on_grid(system, surface, side, level, parity, kGrid);
          places_seen += places.size();
          for (const auto& f : places) {
            double least = geometry::kInfinity;
            for (const Curve& c : result.curves) {
              if (c.level != level || c.parity != parity || c.family_id != family.id) continue;
              least = std::min(least, test::distance_to(c, f.q));
            }
            missed += least > within;
          }
          EXPECT_EQ(missed, 0) << "of " << places.size() << " at level " << level << " parity "
                               << parity << " side " << side;
        }
      }
    }
  }
  EXPECT_TRUE(families_checked == 0 || places_seen > 0);
}

// Of families of several hops the grid is on the receiver, and every change of sign on a sheet is
// near a curve.
void expect_complete_over_hops(const solver::OpticalSystem& system, const ContourResult& result,
                               double within) {
  for (const auto& family : result.families) {
    if (family.surfaces.size() < 2) continue;
    std::vector<double> levels;
    for (std::size_t i = 0; i < result.levels.size(); i += 3) levels.push_back(result.levels[i]);
    const auto [places, lost] = test::places_on_sheets(system, family.surfaces, levels, kHopGrid);
    std::size_t missed = 0;
    for (const auto& place : places) {
      double least = geometry::kInfinity;
      for (const Curve& c : result.curves) {
        if (c.level != place.level || c.parity != place.parity || c.family_id != family.id)
          continue;
        least = std::min(least, test::distance_to(c, place.q));
      }
      missed += least > within;
    }
    EXPECT_EQ(missed, 0u) << "of " << places.size() << ", family " << family.id;
    EXPECT_LE(lost, static_cast<int>(places.size()) / 10) << "family " << family.id;
    EXPECT_GT(places.size(), static_cast<std::size_t>(kHopGrid)) << "family " << family.id;
  }
}

class EveryExample : public testing::TestWithParam<std::string> {};

TEST_P(EveryExample, IsTraced) {
  ContourCall call = read_contour_call(find_example(GetParam())->body);
  call.request.time_limit = 60.0;
  call.request.measure = solver::Measure::sheet;
  const auto result = solver::trace_contours(call.system, call.request);
  EXPECT_TRUE(result.complete);
  EXPECT_FALSE(result.curves.empty());
  test::expect_sound(call.system, result, call.request.irradiance_tolerance, GetParam());
  expect_complete(call.system, result, 1.5e-4 * call.system.receiver().width());
  expect_complete_over_hops(call.system, result, 1.5e-4 * call.system.receiver().width());
}

TEST_P(EveryExample, HasATotalWhoseRegionsClose) {
  const bool longest = GetParam() == "cuboid" || GetParam() == "torus";
  if (test::kSanitized && longest) return;  // TotalContours traces them there
  ContourCall call = read_contour_call(find_example(GetParam())->body);
  call.request.time_limit = 60.0;
  const auto result = solver::trace_contours(call.system, call.request);
  EXPECT_EQ(result.measure, solver::Measure::total);
  EXPECT_EQ(result.undecided_cells, 0u);
  for (const auto& w : result.warnings) EXPECT_EQ(w.code, "conditioning") << w.detail;
  test::expect_closed_rings(result, call.system.receiver().width());
}

std::vector<std::string> names() {
  std::vector<std::string> out;
  for (const Example& example : examples()) out.emplace_back(example.name);
  return out;
}
INSTANTIATE_TEST_SUITE_P(Examples, EveryExample, testing::ValuesIn(names()), [](const auto& name) {
  std::string word = name.param;
  std::erase(word, '-');
  return word;
});

// The box that an expression is given in does not cut the cuboid, so that no light reaches its
// inside; it cuts the waves.
TEST(Examples, ClosedExpressionsAreLitFromOutside) {
  const auto skips_dark_side = [](const char* name) {
    ContourCall call = read_contour_call(find_example(name)->body);
    call.request.isolux = call.request.caustic = false;
    const auto result = solver::trace_contours(call.system, call.request);
    return std::any_of(result.skipped.begin(), result.skipped.end(),
                       [](const auto& skipped) { return skipped.stage == "dark_side"; });
  };
  EXPECT_TRUE(skips_dark_side("cuboid"));
  EXPECT_FALSE(skips_dark_side("water"));
}

// The height that freeform-heights.json samples. Elsewhere its spline is as good as the grid
// allows: E depends on second derivatives, so (2π h)⁴ of the ripple's share of them.
double reflector_height(double x, double y) {
  return (x * x + y * y) / 3.0 +
         0.003 * std::cos(2.0 * geometry::kPi * x) * std::cos(2.0 * geometry::kPi * y) +
         0.03 * x * x * x;
}

// Irradiance by differences of the map, from the formula and not from the samples.
double reflector_irradiance(const Vec2& at) {
  const auto arrival = [](double x, double y) {
    const double h = 1e-5, z = reflector_height(x, y);
    const geometry::Vec3 d(x, y, z - 0.45);
    const geometry::Vec3 n((reflector_height(x - h, y) - reflector_height(x + h, y)) / (2.0 * h),
                           (reflector_height(x, y - h) - reflector_height(x, y + h)) / (2.0 * h),
                           1.0);
    const geometry::Vec3 out = d - 2.0 * d.dot(n) / n.squaredNorm() * n;
    return Vec2(geometry::Vec2(x, y) + (3.0 - z) / out.z() * out.head<2>());
  };
  const double h = 1e-4, x = at.x(), y = at.y(), z = reflector_height(x, y);
  const Vec2 dx = (arrival(x + h, y) - arrival(x - h, y)) / (2.0 * h);
  const Vec2 dy = (arrival(x, y + h) - arrival(x, y - h)) / (2.0 * h);
  const geometry::Vec3 d(x, y, z - 0.45);
  const geometry::Vec3 n((reflector_height(x - h, y) - reflector_height(x + h, y)) / (2.0 * h),
                         (reflector_height(x, y - h) - reflector_height(x, y + h)) / (2.0 * h),
                         1.0);
  const double flux = 0.9 * 100.0 / (4.0 * geometry::kPi) * -d.dot(n) / std::pow(d.norm(), 3);
  return flux / std::abs(dx.x() * dy.y() - dx.y() * dy.x());
}

TEST(FreeformHeights, ItsContoursAreThoseOfTheSampledShape) {
  ContourCall call = read_contour_call(find_example("freeform-heights")->body);
  call.request.measure = solver::Measure::sheet;
  const auto result = solver::trace_contours(call.system, call.request);
  int checked = 0;
  for (const Curve& c : result.curves) {
    if (c.kind == solver::CurveKind::caustic) continue;
    for (std::size_t i = 0; i < c.vertices.size(); i += 5, ++checked)
      EXPECT_NEAR(reflector_irradiance(c.vertices[i].x.head<2>()) / c.level, 1.0, 2e-3);
  }
  EXPECT_GT(checked, 100);
}

}  // namespace
}  // namespace caustic::service
