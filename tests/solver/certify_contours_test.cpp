// Contours with the proof that none is missed.
#include "solver/certify_contours.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/expression/field.h"
#include "tests/support/scenes.h"

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

}  // namespace
}  // namespace caustic::solver
