// What a request skips it does not need: told to do it all the same, it finds the same curves.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <map>
#include <string_view>
#include <tuple>

#include "service/api/contour_json.h"
#include "service/examples/examples.h"
#include "solver/plan.h"
#include "tests/support/distance_to.h"
#include "tests/support/thorough.h"

namespace caustic::service {
namespace {

using solver::ContourResult;
using solver::Curve;

// Visibility is a question of yes or no, whoever is asked, and zeros may be added.
bool leaves_every_bit(std::string_view stage) {
  return stage == "visibility" || stage == "embree" || stage == "third_derivatives";
}

auto kind_of(const Curve& c) {
  return std::tuple(c.kind, c.level, c.family_id, c.parity, c.boundary, c.closed, c.ends);
}

void expect_same_bits(const ContourResult& a, const ContourResult& b) {
  ASSERT_EQ(a.curves.size(), b.curves.size());
  for (std::size_t i = 0; i < a.curves.size(); ++i) {
    const auto &u = a.curves[i].vertices, &v = b.curves[i].vertices;
    EXPECT_EQ(kind_of(a.curves[i]), kind_of(b.curves[i])) << i;
    EXPECT_TRUE(std::equal(u.begin(), u.end(), v.begin(), v.end(),
                           [](const auto& p, const auto& q) {
                             return p.x == q.x && p.uv == q.uv && p.irradiance == q.irradiance;
                           }))
        << i;
  }
}

// No vertex of one is further than this from the polyline of the other.
double distance(const Curve& a, const Curve& b) {
  double most = 0.0;
  for (const auto& v : a.vertices) most = std::max(most, test::distance_to(b, v.uv));
  for (const auto& v : b.vertices) most = std::max(most, test::distance_to(a, v.uv));
  return most;
}

void expect_same_curves(const ContourResult& a, const ContourResult& b, double within) {
  ASSERT_EQ(a.curves.size(), b.curves.size());
  std::vector<bool> taken(b.curves.size());
  for (const Curve& c : a.curves) {
    bool found = false;
    for (std::size_t i = 0; i < b.curves.size() && !found; ++i) {
      found = !taken[i] && kind_of(c) == kind_of(b.curves[i]) && distance(c, b.curves[i]) <= within;
      if (found) taken[i] = true;
    }
    EXPECT_TRUE(found) << to_string(c.kind) << " of level " << c.level << " with "
                       << c.vertices.size() << " vertices";
  }
}

// Boundaries that nothing shows of may divide a ring into more arcs: rings are compared as a whole.
ContourResult in_rings(ContourResult result) {
  std::map<std::pair<double, int>, Curve> rings;
  std::vector<Curve> kept;
  std::sort(result.curves.begin(), result.curves.end(), [](const Curve& a, const Curve& b) {
    return std::tie(a.ring_id, a.ring_order) < std::tie(b.ring_id, b.ring_order);
  });
  for (const Curve& c : result.curves) {
    if (c.ring_id < 0) {
      kept.push_back(c);
      continue;
    }
    Curve& ring = rings[{c.level, c.ring_id}];
    ring.level = c.level;
    ring.closed = true;
    ring.vertices.insert(ring.vertices.end(), c.vertices.begin(), c.vertices.end());
  }
  for (auto& [key, ring] : rings) kept.push_back(std::move(ring));
  result.curves = std::move(kept);
  return result;
}

void expect_stages_to_change_nothing(const std::string& example, solver::Measure measure) {
  ContourCall call = read_contour_call(find_example(example)->body);
  solver::ContourRequest& request = call.request;
  request.time_limit = 300.0;
  request.measure = measure;
  if (request.levels.values.empty()) request.levels.count = 3;
  const double width = call.system.receiver().width();
  request.chord_tolerance = 1e-3 * width;
  const ContourResult planned = solver::trace_contours(call.system, request);
  EXPECT_FALSE(planned.curves.empty());
  const auto stages = solver::skippable_stages();
  for (const auto& [stage, reason] : planned.skipped) {
    if (stage == "empty_levels") continue;  // costs nothing
    SCOPED_TRACE(example + " --no-skip " + stage);
    EXPECT_EQ(std::count(stages.begin(), stages.end(), std::string_view(stage)), 1);
    request.no_skip = {stage};
    const ContourResult forced = solver::trace_contours(call.system, request);
    // Whom to ask is no question where nothing is asked.
    const bool of_no_use = stage == "embree" && reason == "visibility is not asked";
    for (const auto& other : forced.skipped) EXPECT_TRUE(of_no_use || other.stage != stage);
    if (leaves_every_bit(stage))
      expect_same_bits(planned, forced);
    else if (measure == solver::Measure::sheet)
      expect_same_curves(planned, forced, 2.0 * request.chord_tolerance);
    else
      expect_same_curves(in_rings(planned), in_rings(forced), 2.0 * request.chord_tolerance);
  }
}

// Examples that take a tenth of a second with every stage.
std::vector<std::string> quick_examples() {
  return {"nephroid", "ellipsoid-bowl", "plane-mirror", "telescope"};
}
std::vector<std::string> all_examples() {
  std::vector<std::string> out;
  for (const Example& example : examples()) out.emplace_back(example.name);
  return out;
}
std::string word(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::erase(name, '-');
  return name;
}

class SkippedStagesOfSheets : public testing::TestWithParam<std::string> {};
TEST_P(SkippedStagesOfSheets, ChangeNothing) {
  expect_stages_to_change_nothing(GetParam(), solver::Measure::sheet);
}
INSTANTIATE_TEST_SUITE_P(Examples, SkippedStagesOfSheets,
                         testing::ValuesIn(test::kSanitized ? quick_examples() : all_examples()),
                         word);

// All examples by ISOCAUSTIC_STAGES=all.
class SkippedStagesOfTotals : public testing::TestWithParam<std::string> {};
TEST_P(SkippedStagesOfTotals, ChangeNothing) {
  expect_stages_to_change_nothing(GetParam(), solver::Measure::total);
}
INSTANTIATE_TEST_SUITE_P(Examples, SkippedStagesOfTotals,
                         testing::ValuesIn(std::getenv("ISOCAUSTIC_STAGES") ? all_examples()
                                                                            : quick_examples()),
                         word);

// A family that brings little is left out only because the request says so.
TEST(SkippedStages, AFaintFamilyIsTracedIfTold) {
  ContourCall call = read_contour_call(find_example("two-mirrors")->body);
  call.request.measure = solver::Measure::sheet;
  call.request.min_flux_share = 0.9;
  const auto without = solver::trace_contours(call.system, call.request);
  call.request.no_skip = {"family"};
  const auto with = solver::trace_contours(call.system, call.request);
  const auto skips = [](const ContourResult& result) {
    return std::any_of(result.skipped.begin(), result.skipped.end(),
                       [](const auto& skipped) { return skipped.stage == "family"; });
  };
  EXPECT_TRUE(skips(without));
  EXPECT_FALSE(skips(with));
  EXPECT_GT(with.curves.size(), without.curves.size());
}

}  // namespace
}  // namespace caustic::service
