// What exploration must not miss, and what it measures on the way.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "solver/contours.h"
#include "solver/point_irradiance.h"

namespace caustic::solver {
namespace {

using namespace geometry;

// A mirror cap or disc of radius r, tilted against every grid, far smaller than what it is cut
// from.
TEST(Explore, small_apertures_are_found) {
  for (const double r : {1.0, 0.1, 1e-3}) {
    for (const double tilt : {0.11, 0.37, 0.73}) {
      const Direction d = Vec3(std::sin(tilt), 0.3 * std::sin(tilt), std::cos(tilt)).normalized();
      const Frame across(d);
      const auto receiver = ReceiverFrame::make(25.0 * d, across.e1, across.e2, {40, 40});
      const Point light = 20.0 * d + Vec3(1, 0, 0);
      const std::vector<Bound> disc{cylinder_aperture({0, 0, 0}, d, r)};
      std::vector<Bound> cap = disc;
      cap.push_back(half_space_aperture({0, 0, 0}, -d));
      struct Case {
        SurfacePtr shape;
        std::vector<Bound> bounds;
        Point middle;
      };
      for (const Case& c : {Case{make_plane({0, 0, 0}, d), disc, {0, 0, 0}},
                            Case{make_sphere({0, 0, 0}, 10.0), cap, 10.0 * d}}) {
        const auto system = OpticalSystem::build(PointLight{light, 1.0},
                                                 {{"m", c.shape, c.bounds, {}, {}}}, receiver);
        ContourRequest request;
        request.levels.count = 4;
        const auto result = trace_contours(system, request);
        EXPECT_GE(result.curves.size(), 3u) << r << " " << tilt;
        // Solid angle of a small disc, π r² cos/d².
        const Vec3 ray = c.middle - light;
        const double flux =
            std::numbers::pi * r * r * std::abs(ray.dot(d)) / std::pow(ray.norm(), 3);
        EXPECT_NEAR(result.families[0].flux / flux, 1.0, 0.03) << r << " " << tilt;
      }
    }
  }
}

// The flux of A1 by a one-dimensional integral over the cone of light that the ball reflects into
// the window: 8 ∫₀^{π/4} (1 − cos β(6/cos φ)) dφ, with β(r) by bisection of the traced meridian
// ray.
TEST(Explore, flux_of_a_ball_on_a_ceiling) {
  const auto landing = [](double beta) {
    const double b = 4.0 * std::cos(beta), t = b - std::sqrt(b * b - 15.0);
    const double x = t * std::sin(beta), z = 4.0 - t * std::cos(beta);
    const double dn = std::sin(beta) * x - std::cos(beta) * z;
    const double rx = std::sin(beta) - 2.0 * dn * x, rz = -std::cos(beta) - 2.0 * dn * z;
    return rz > 0.0 ? x + (6.0 - z) / rz * rx : kInfinity;
  };
  const auto cos_beta = [&](double r) {
    double lo = 0.0, hi = std::asin(0.25);
    for (int i = 0; i < 100; ++i) {
      const double middle = 0.5 * (lo + hi);
      (landing(middle) < r ? lo : hi) = middle;
    }
    return std::cos(lo);
  };
  double sum = 0.0;
  constexpr int n = 400;
  for (int i = 0; i < n; ++i) sum += 1.0 - cos_beta(6.0 / std::cos((i + 0.5) * kPi / (4 * n)));
  const double flux = 8.0 * sum * kPi / (4 * n);

  const auto system = OpticalSystem::build(
      PointLight{{0, 0, 4}, 1.0}, {{"ball", make_sphere({0, 0, 0}, 1.0), {}, {}, {}}},
      ReceiverFrame::make({0, 0, 6}, {1, 0, 0}, {0, 1, 0}, {12, 12}));
  const auto result = trace_contours(system, {});
  EXPECT_NEAR(result.families[0].flux / flux, 1.0, 1e-4);
}

// Which sign g has inside is the user's; a beam reaches the outside of a closed shape either way.
TEST(Explore, a_sphere_with_either_sign_of_its_coefficients) {
  const std::array<double, 10> plus{1, 1, 1, 0, 0, 0, 0, 0, 0, -1};
  std::array<double, 10> minus = plus;
  for (double& c : minus) c = -c;
  for (const Light& light : {Light(CollimatedLight{Vec3(0.1, 0, -1).normalized(), 1.0}),
                             Light(PointLight{{0.3, 0, 4}, 1.0})}) {
    std::vector<std::size_t> curves;
    for (const auto& coefficients : {plus, minus}) {
      const auto system =
          OpticalSystem::build(light, {{"q", make_quadric(coefficients, {}).surface, {}, {}, {}}},
                               ReceiverFrame::make({0, 0, 5}, {1, 0, 0}, {0, 1, 0}, {8, 8}));
      curves.push_back(trace_contours(system, {}).curves.size());
    }
    EXPECT_GT(curves[0], 0u);
    EXPECT_EQ(curves[0], curves[1]);
  }
}

// A light so near above a ball of air in glass that it lights next to nothing of it. On the axis
// below E → I (n_air/n_glass)²/depth², since dΩ_air = (n_glass/n_air)² dΩ_glass there. The meter
// has a search of its own.
TEST(Explore, what_a_near_light_lights_is_found) {
  const Optics glass_outside{Optics::Kind::refract, 1.0, {}, 1.5, 1.0};
  for (const double height : {1e-3, 1e-5, 1e-8}) {
    const auto system =
        OpticalSystem::build(PointLight{{0, 0, 1.0 + height}, 1.0},
                             {{"ball", make_sphere({0, 0, 0}, 1.0), {}, glass_outside, {}}},
                             ReceiverFrame::make({0, 0, 0.9}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2}));
    LightMeter meter(system, {}, false);
    EXPECT_NEAR(meter.at({0, 0}).E, 1.0 / 2.25 / 0.01, 1e3 * height) << height;
    ContourRequest request;
    request.levels.values = {8.0, 20.0, 40.0};
    const auto result = trace_contours(system, request);
    std::map<double, int> vertices;
    for (const Curve& curve : result.curves) {
      for (const CurveVertex& v : curve.vertices) {
        if (++vertices[curve.level] % 20 != 1) continue;
        // Rounding of the place moves E by its share of the height.
        EXPECT_NEAR(meter.at(v.uv).E / curve.level, 1.0, 1e-8 + 5e-14 / height);
      }
    }
    EXPECT_EQ(vertices.size(), 3u) << height;
  }
}

}  // namespace
}  // namespace caustic::solver
