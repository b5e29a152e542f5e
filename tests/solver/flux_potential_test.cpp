// Line integrals of the flux potential round closed curves on a mirror against solid angles and
// areas in closed form (S60).
#include "solver/flux_potential.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/scenes.h"

namespace caustic::solver {
namespace {

using geometry::kPi;
using test::floor_at;
using test::one_mirror;

/// A ball's mirror from one side, explored.
struct Explored {
  Explored(const OpticalSystem& system, int side)
      : budget(60.0, 1000000, nullptr), field(system, {0, Hops{{0, side}}, false}, nullptr, 0.0) {
    field.explore(budget);
  }
  Budget budget;
  FamilyField field;
};

/// Round the circle in which a cone about `axis` from the light meets the unit sphere from inside,
/// anticlockwise as the light sees it, by the trapezoidal rule.
double circulation(const FluxPotential& potential, const Point& light, const Vec3& axis,
                   double angle) {
  const geometry::Frame frame(axis);
  constexpr int kPoints = 400;
  double sum = 0.0;
  const auto place = [&](double phi) {
    const Vec3 d = std::cos(angle) * axis +
                   std::sin(angle) * (std::cos(phi) * frame.e1 + std::sin(phi) * frame.e2);
    const double b = light.dot(d);
    return Point(light + (-b + std::sqrt(b * b + 1.0 - light.squaredNorm())) * d);
  };
  for (int i = 0; i < kPoints; ++i) {
    // The light looks along the axis: anticlockwise is −φ.
    const double phi = -2.0 * kPi * i / kPoints, h = 1e-4;
    const Vec3 x_phi =
        (8.0 * (place(phi + h) - place(phi - h)) - (place(phi + 2 * h) - place(phi - 2 * h))) /
        (12.0 * h);
    sum += potential.along(place(phi), -x_phi).value * 2.0 * kPi / kPoints;
  }
  return sum;
}

TEST(FluxPotential, RoundAConeIsItsSolidAngle) {
  const Point lamp(0.1, 0.05, 0.3);
  const auto bowl = one_mirror(PointLight{lamp, 2.0}, geometry::make_sphere(Point::Zero(), 1.0),
                               floor_at({0, 0, 0.9}, 1, 1),
                               geometry::box_aperture({-1, -1, -1}, {1, 1, -0.2}), 0.5);
  const Explored explored(bowl, -1);
  const FluxPotential potential(explored.field, bowl.light());
  EXPECT_FALSE(potential.pole());
  for (const Vec3& axis : {Vec3(0, 0, -1), Vec3(0.3, -0.2, -1).normalized()}) {
    EXPECT_NEAR(circulation(potential, lamp, axis, 0.4), 2.0 * kPi * (1.0 - std::cos(0.4)), 1e-9);
  }
}

// Where light goes all round there is a pole on the way: a region that holds it lacks 4πρI.
TEST(FluxPotential, HasAPoleWhereLightGoesAllRound) {
  const Point lamp(0.1, 0.05, 0.3);
  const auto closed = one_mirror(PointLight{lamp, 2.0}, geometry::make_sphere(Point::Zero(), 1.0),
                                 floor_at({0, 0, -0.1}, 1.8, 1.8), {}, 0.5);
  const Explored explored(closed, -1);
  const FluxPotential potential(explored.field, closed.light());
  ASSERT_TRUE(potential.pole());
  EXPECT_NEAR(potential.pole_flux(), 4.0 * kPi, 1e-12);
  const Vec3 to_pole = (potential.pole()->x - lamp).normalized();
  for (const double angle : {0.2, 1.0}) {
    const double cone = 2.0 * kPi * (1.0 - std::cos(angle));
    EXPECT_NEAR(circulation(potential, lamp, to_pole, angle), cone - potential.pole_flux(), 1e-8);
    EXPECT_NEAR(circulation(potential, lamp, -to_pole, angle), cone, 1e-8);
  }
}

TEST(FluxPotential, OfABeamIsTheAreaAcrossIt) {
  const Vec3 beam = Vec3(0.2, -0.1, -1).normalized();
  const auto bowl =
      one_mirror(CollimatedLight{beam, 3.0}, geometry::make_sphere(Point::Zero(), 1.0),
                 floor_at({0, 0, -0.2}, 1, 1), geometry::box_aperture({-1, -1, -1}, {1, 1, -0.6}));
  const Explored explored(bowl, -1);
  const FluxPotential potential(explored.field, bowl.light());
  // An ellipse about the middle of the bowl: along x and y with half axes 0.2 and 0.3.
  double sum = 0.0;
  constexpr int kPoints = 200;
  for (int i = 0; i < kPoints; ++i) {
    const double phi = 2.0 * kPi * i / kPoints;
    const Vec3 x(0.2 * std::cos(phi), 0.3 * std::sin(phi), 0.0);
    const Vec3 x_phi(-0.2 * std::sin(phi), 0.3 * std::cos(phi), 0.0);
    const double z = -std::sqrt(1.0 - x.squaredNorm());
    const Vec3 slope(x_phi.x(), x_phi.y(), -x.dot(x_phi) / z);
    sum += potential.along({x.x(), x.y(), z}, slope).value * 2.0 * kPi / kPoints;
  }
  // ∫ E_b (−ω·n) dS over the bowl inside it; by the tilt the area of the curve across the beam,
  // which is that of its projection down, plus what it leans over.
  double expected = 3.0 * kPi * 0.2 * 0.3 * -beam.z();
  for (int i = 0; i < kPoints; ++i) {
    const double phi = 2.0 * kPi * i / kPoints;
    const double u = 0.2 * std::cos(phi), v = 0.3 * std::sin(phi),
                 z = -std::sqrt(1 - u * u - v * v);
    expected += 3.0 * z * (beam.x() * 0.3 * std::cos(phi) + beam.y() * 0.2 * std::sin(phi)) * 2.0 *
                kPi / kPoints;
  }
  EXPECT_NEAR(sum, expected, 1e-10);
}

}  // namespace
}  // namespace caustic::solver
