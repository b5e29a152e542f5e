#include "solver/forward_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/reference.h"
#include "tests/support/sampling.h"
#include "tests/support/thorough.h"

namespace caustic::solver {
namespace {

using test::Random;
using test::ReferenceScene;
using test::ShapeSpec;

// Sanitizers slow 50-digit arithmetic tenfold. Quadrics, conics and freeforms come in many classes
// each.
constexpr int kPoints = test::thorough(1000, 40), kPointsOfClass = test::thorough(200, 20);
constexpr int kPointsPerScene = 10;

// Required of a, ∇a, flux: error in units of their natural scale.
constexpr double kTolerance = 1e-12;
// Positions of order one carry a rounding error of ε. It turns the normal by ε × curvature and
// moves a by that over the sine of arrival, thrice. Beyond this bound (apexes of cones) the numbers
// given do not say what a is to within the tolerance; so too next to the rim of a conic, where its
// height has an infinite slope.
constexpr double kLargestBending = 200.0;
constexpr double kRimMargin = 1e-3;

OpticalSystem system_of(const ReferenceScene& scene) {
  SystemSurface surface{
      .name = "mirror", .shape = test::build(scene.shape), .bounds = {}, .optics = {}};
  surface.optics.reflectance = scene.reflectance;
  return OpticalSystem::build(scene.light, {surface}, scene.receiver);
}

ReferenceScene random_scene(const ShapeSpec& shape, bool point_light, Random& random) {
  ReferenceScene scene{
      .shape = shape,
      .side = random.index(2) == 0 ? 1 : -1,
      .reflectance = random.uniform(0.2, 1.0),
      .light = {},
      .receiver = geometry::ReceiverFrame::make(random.in_cube(4.0), random.direction(),
                                                random.direction(), {5.0, 3.0})};
  if (point_light) {
    scene.light = PointLight{random.in_cube(4.0), random.uniform(0.5, 20.0)};
  } else {
    scene.light = CollimatedLight{random.direction(), random.uniform(0.5, 20.0)};
  }
  return scene;
}

// Largest errors, each in units of its natural scale.
struct Worst {
  double q = 0, a = 0, grad_a = 0, flux = 0, grad_flux = 0;
};

Worst compare(const ShapeSpec& shape, bool point_light, int points, Random& random) {
  Worst worst;
  for (int done = 0; done < points;) {
    const ReferenceScene scene = random_scene(shape, point_light, random);
    const OpticalSystem system = system_of(scene);
    const ForwardMap map(system, 0, scene.side);
    for (const Point& x :
         test::sample_surface(map.shape(), test::extent_about(shape.pose.translation, 3.0),
                              kPointsPerScene, random)) {
      if (!geometry::exists_at(map.shape().own_bounds(), x, -kRimMargin)) continue;
      const FieldPoint f = map.evaluate(x);
      const auto r = test::reference_field(scene, x);
      if (r.curvature > kLargestBending * std::abs(r.incidence)) continue;
      ++done;
      EXPECT_TRUE(f.finite);
      EXPECT_EQ(f.facing > 0.0, r.incidence > 0.0);
      EXPECT_NEAR(f.n.cross(f.e1).dot(f.e2), 1.0, 1e-15);
      const auto note = [](double& largest, double error) { largest = std::max(largest, error); };
      note(worst.q, (f.q - r.q).norm() * std::abs(r.incidence) / (10.0 + r.q.norm()));
      note(worst.a, std::abs(f.a - r.a) / r.scale_of_a);
      // A plane's magnification in a beam is constant: no term of ∇a is left to measure by.
      note(worst.grad_a, (f.grad_a - r.grad_a).norm() / (r.scale_of_grad_a + 0.1 * r.scale_of_a));
      note(worst.flux, std::abs(f.flux - r.flux) / r.scale_of_flux);
      note(worst.grad_flux,
           (f.grad_flux - r.grad_flux).norm() / (r.scale_of_grad_flux + 0.01 * r.scale_of_flux));
    }
  }
  return worst;
}

class AgainstReference : public testing::TestWithParam<std::tuple<ShapeSpec, bool>> {};

TEST_P(AgainstReference, MagnificationFluxAndGradients) {
  const auto& [shape, point_light] = GetParam();
  const bool has_classes = shape.kind == ShapeSpec::Kind::quadric ||
                           shape.kind == ShapeSpec::Kind::conic ||
                           shape.kind >= ShapeSpec::Kind::revolution;
  Random random(point_light ? 1001 : 1000);
  const Worst worst = compare(shape, point_light, has_classes ? kPointsOfClass : kPoints, random);
  EXPECT_LT(worst.q, kTolerance);
  EXPECT_LT(worst.a, kTolerance);
  EXPECT_LT(worst.grad_a, kTolerance);
  EXPECT_LT(worst.flux, kTolerance);
  EXPECT_LT(worst.grad_flux, kTolerance);
  RecordProperty("figures", testing::PrintToString(std::array{worst.q, worst.a, worst.grad_a,
                                                              worst.flux, worst.grad_flux}));
}

INSTANTIATE_TEST_SUITE_P(Shapes, AgainstReference,
                         testing::Combine(testing::ValuesIn(test::shape_zoo()), testing::Bool()),
                         [](const auto& spec) {
                           return std::get<0>(spec.param).name +
                                  (std::get<1>(spec.param) ? "_point" : "_collimated");
                         });

}  // namespace
}  // namespace caustic::solver
