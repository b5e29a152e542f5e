// Families of several hops: derivatives against 50 digits, and scenes whose answer is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "solver/contours.h"
#include "solver/forward_map.h"
#include "solver/itineraries.h"
#include "tests/support/reference.h"
#include "tests/support/sampling.h"
#include "tests/support/thorough.h"

namespace caustic::solver {
namespace {

using test::Random;
using test::ReferenceScene;
using test::ShapeSpec;

constexpr int kFamilyPaths = test::thorough(300, 15);

Optics random_optics(Random& random) {
  Optics optics;
  switch (random.index(4)) {
    case 0:
      optics.reflectance = random.uniform(0.3, 1.0);
      break;
    case 1:
      optics.metal = std::complex(random.uniform(0.1, 3.0), random.uniform(0.5, 6.0));
      break;
    default:
      optics.kind = Optics::Kind::refract;
      optics.index_outside = random.uniform(1.0, 1.8);
      optics.index_inside = random.uniform(1.0, 1.8);
      optics.fresnel = random.index(2) == 0;
  }
  return optics;
}

// Surfaces of mixed shapes at random places; the family visits each once, by the sides that occur.
struct RandomFamily {
  ReferenceScene reference;
  std::vector<SystemSurface> surfaces;
};

RandomFamily random_family(int hops, Random& random) {
  RandomFamily family;
  const auto& zoo = test::shape_zoo();
  std::vector<ShapeSpec> shapes;
  for (int j = 0; j < hops; ++j) {
    ShapeSpec shape = zoo[static_cast<std::size_t>(random.index(static_cast<int>(zoo.size())))];
    if (j > 0) shape.pose.translation += random.in_cube(6.0);
    shapes.push_back(shape);
    SystemSurface surface{.name = std::to_string(j),
                          .shape = test::build(shape),
                          .bounds = {},
                          .optics = random_optics(random)};
    family.surfaces.push_back(surface);
  }
  auto& r = family.reference;
  r.shape = shapes[0];
  r.reflectance = family.surfaces[0].optics.constant_share()
                      ? family.surfaces[0].optics.share(1, 1.0).value
                      : 1.0;
  r.optics = family.surfaces[0].optics;
  r.receiver = geometry::ReceiverFrame::make(random.in_cube(8.0), random.direction(),
                                             random.direction(), {5.0, 3.0});
  if (random.index(2) == 0) {
    r.light = PointLight{random.in_cube(4.0), random.uniform(0.5, 20.0)};
  } else {
    r.light = CollimatedLight{random.direction(), random.uniform(0.5, 20.0)};
  }
  for (int j = 1; j < hops; ++j) r.later.push_back({shapes[j], 1, family.surfaces[j].optics});
  return family;
}

struct WorstOfPath {
  double q = 0, a = 0, grad_a = 0, flux = 0, grad_flux = 0;
};

// How much rounding of the hits moves a, in units of its scale: bending over the sine of arrival,
// at every hop.
bool well_posed(const FieldPoint& f, int hops) {
  for (int j = 0; j < hops; ++j) {
    if (f.hits && (f.hits[j].cosine < 0.2 || f.hits[j].headroom < 0.05)) return false;
    if (f.hits && (f.hits[j].y_s.norm() > 20.0 || f.hits[j].y_t.norm() > 20.0)) return false;
    if (f.hits && (f.hits[j].grad_cosine.norm() > 20.0)) return false;
  }
  return f.q.norm() < 50.0;
}

WorstOfPath compare(int hops, int paths, Random& random) {
  WorstOfPath worst;
  for (int done = 0, tries = 0; done < paths && tries < 200 * paths; ++tries) {
    RandomFamily family = random_family(hops, random);
    auto& r = family.reference;
    const auto system = OpticalSystem::build(r.light, family.surfaces, r.receiver);
    Hops chain;
    for (int j = 0; j < hops; ++j) chain.push_back({j, random.index(2) == 0 ? 1 : -1});
    const ForwardMap map(system, chain);
    for (const Point& x : test::sample_surface(
             map.shape(), test::extent_about(r.shape.pose.translation, 3.0), 20, random)) {
      if (!geometry::exists_at(map.shape().own_bounds(), x, -1e-2)) continue;
      const FieldPoint f = map.evaluate(x);
      if (!f.finite || !f.lit() || !well_posed(f, hops)) continue;
      bool inside = true;
      for (int j = 1; j < hops; ++j) {
        const auto& hit = f.hits[j];
        inside &= geometry::exists_at(map.surface(j).bounds, hit.y, -1e-2);
        auto& hop = r.later[j - 1];
        hop.side = chain[j].side;
        hop.distance = (hit.y - (j > 1 ? f.hits[j - 1].y : x)).norm();
      }
      if (!inside) continue;
      r.side = chain[0].side;
      const auto expected = test::reference_field(r, x);
      if (expected.curvature > 10.0 || std::abs(expected.incidence) < 0.2) continue;
      ++done;
      const auto note = [](double& largest, double error) { largest = std::max(largest, error); };
      note(worst.q, (f.q - expected.q).norm() / (10.0 + f.q.norm()));
      note(worst.a, std::abs(f.a - expected.a) / expected.scale_of_a);
      note(worst.grad_a, (f.grad_a - expected.grad_a).norm() /
                             (expected.scale_of_grad_a + 0.1 * expected.scale_of_a));
      note(worst.flux, std::abs(f.flux - expected.flux) / expected.scale_of_flux);
      note(worst.grad_flux, (f.grad_flux - expected.grad_flux).norm() /
                                (expected.scale_of_grad_flux + 0.1 * expected.scale_of_flux));
      if (done >= paths) break;
    }
  }
  return worst;
}

class Hopping : public testing::TestWithParam<int> {};

TEST_P(Hopping, DerivativesAgainstFiftyDigits) {
  const int hops = GetParam();
  Random random(static_cast<unsigned>(7000 + hops));
  const WorstOfPath worst = compare(hops, kFamilyPaths, random);
  // Every hop multiplies the rounding of the place by the curvature and the way to the next.
  constexpr double kTolerance = 1e-11;
  EXPECT_GT(worst.a, 0.0);
  EXPECT_LT(worst.q, kTolerance);
  EXPECT_LT(worst.a, kTolerance);
  EXPECT_LT(worst.grad_a, kTolerance);
  EXPECT_LT(worst.flux, kTolerance);
  EXPECT_LT(worst.grad_flux, kTolerance);
  RecordProperty("figures", testing::PrintToString(std::array{worst.q, worst.a, worst.grad_a,
                                                              worst.flux, worst.grad_flux}));
}

INSTANTIATE_TEST_SUITE_P(Families, Hopping, testing::Values(1, 2, 3));

// The general way and the short one for a single mirror must not differ.
TEST(Hopping, OneMirrorBothWays) {
  Random random(7100);
  for (int scene = 0; scene < 20; ++scene) {
    const auto& zoo = test::shape_zoo();
    const ShapeSpec& shape =
        zoo[static_cast<std::size_t>(random.index(static_cast<int>(zoo.size())))];
    SystemSurface plain{.name = "m", .shape = test::build(shape), .bounds = {}, .optics = {}};
    SystemSurface metal = plain;
    metal.optics.metal = std::complex(0.2, 3.0);
    const auto receiver = geometry::ReceiverFrame::make(random.in_cube(4.0), random.direction(),
                                                        random.direction(), {5.0, 3.0});
    const PointLight light{random.in_cube(4.0), 1.0};
    const auto a = OpticalSystem::build(light, {plain}, receiver);
    const auto b = OpticalSystem::build(light, {metal}, receiver);
    const ForwardMap short_way(a, 0, 1), long_way(b, 0, 1);
    for (const Point& x : test::sample_surface(
             short_way.shape(), test::extent_about(shape.pose.translation, 3.0), 10, random)) {
      const FieldPoint f = short_way.evaluate(x), g = long_way.evaluate(x);
      if (!f.finite || !f.lit() || f.q.norm() > 50.0) continue;
      const double scale = f.scale_of_a();
      EXPECT_NEAR((f.q - g.q).norm(), 0.0, 1e-11 * (1.0 + f.q.norm()));
      EXPECT_NEAR(f.a, g.a, 1e-11 * scale);
      EXPECT_NEAR((f.grad_a - g.grad_a).norm(), 0.0, 1e-10 * (scale + f.grad_a.norm()));
      EXPECT_NEAR(f.flux * g.share, g.flux, 1e-14 * f.flux);
    }
  }
}

Optics glass(double inside, bool fresnel = false) {
  Optics optics;
  optics.kind = Optics::Kind::refract;
  optics.index_inside = inside;
  optics.fresnel = fresnel;
  return optics;
}

// Plane interface: at the hit r from the foot of the light at height h, over a floor at depth t,
// the ray arrives at R = r + t tan θ′, and by conservation E = (dΦ/dr)/(2πR dR/dr).
TEST(Refraction, PlaneInterface) {
  const double h = 1.3, t = 0.8, n = 1.33;
  for (const double eta : {1.0 / n, n}) {
    SystemSurface water{.name = "w",
                        .shape = geometry::make_plane(Point::Zero(), {0, 0, 1}),
                        .bounds = {},
                        .optics = glass(n)};
    const bool from_outside = eta < 1.0;
    const double up = from_outside ? 1.0 : -1.0;
    const auto receiver =
        geometry::ReceiverFrame::make({0, 0, -up * t}, {1, 0, 0}, {0, 1, 0}, {50, 50});
    const auto system = OpticalSystem::build(PointLight{{0, 0, up * h}, 1.0}, {water}, receiver);
    const ForwardMap map(system, Hops{{0, from_outside ? 1 : -1}});
    for (const double r : {0.01, 0.2, 0.7, 1.0}) {
      const double d = std::hypot(r, h), sine = eta * r / d, cosine = std::sqrt(1.0 - sine * sine);
      const double arrival = r + t * sine / cosine;
      const double stretch = 1.0 + t * eta * (h * h / (d * d * d)) / (cosine * cosine * cosine);
      const double expected = (h / (d * d * d)) * r / (arrival * stretch);
      const FieldPoint f = map.evaluate({r, 0, 0});
      ASSERT_TRUE(f.finite);
      EXPECT_NEAR(f.q.x(), arrival, 1e-13);
      EXPECT_NEAR(f.irradiance(), expected, 1e-13 * expected);
    }
    // Beyond the critical angle nothing passes.
    if (!from_outside) {
      EXPECT_FALSE(map.evaluate({10.0, 0, 0}).finite);
    }
  }
}

// A slab moves every ray sideways by t sin θ (1 − cos θ/(n cos θ′)) and turns none.
TEST(Refraction, ParallelSlab) {
  const double n = 1.5, t = 0.4;
  SystemSurface top{.name = "top",
                    .shape = geometry::make_plane({0, 0, t}, {0, 0, 1}),
                    .bounds = {},
                    .optics = glass(n)};
  SystemSurface bottom{.name = "bottom",
                       .shape = geometry::make_plane({0, 0, 0}, {0, 0, -1}),
                       .bounds = {},
                       .optics = glass(n)};
  const auto receiver = geometry::ReceiverFrame::make({0, 0, -1}, {1, 0, 0}, {0, 1, 0}, {50, 50});
  for (const double angle : {0.0, 0.3, 0.9, 1.4}) {
    const Vec3 beam(std::sin(angle), 0, -std::cos(angle));
    const auto system = OpticalSystem::build(CollimatedLight{beam, 1.0}, {top, bottom}, receiver);
    const ForwardMap map(system, Hops{{0, 1}, {1, -1}});
    const FieldPoint f = map.evaluate({0, 0, t});
    ASSERT_TRUE(f.finite);
    const double inner = std::sqrt(1.0 - std::pow(std::sin(angle) / n, 2));
    const double aside = t * std::sin(angle) * (1.0 - std::cos(angle) / (n * inner));
    // The straight ray would arrive at (t + 1) tan θ.
    EXPECT_NEAR(f.q.x(), (t + 1.0) * std::tan(angle) - aside / std::cos(angle), 1e-13);
    EXPECT_NEAR(f.a, 1.0, 1e-12);
    EXPECT_NEAR(f.irradiance(), std::cos(angle), 1e-12);
  }
}

// Paraxial: a ball lens of index n focuses a beam at n/(2(n − 1)) radii from its centre.
TEST(Refraction, BallLensOnAxis) {
  const double n = 1.5, focus = n / (2.0 * (n - 1.0));
  SystemSurface ball{.name = "ball",
                     .shape = geometry::make_sphere(Point::Zero(), 1.0),
                     .bounds = {},
                     .optics = glass(n)};
  const auto evaluate = [&](double z) {
    const auto receiver = geometry::ReceiverFrame::make({0, 0, -z}, {1, 0, 0}, {0, 1, 0}, {2, 2});
    const auto system = OpticalSystem::build(CollimatedLight{{0, 0, -1}, 1.0}, {ball}, receiver);
    return ForwardMap(system, Hops{{0, 1}, {0, -1}}).evaluate({0, 0, 1}).a;
  };
  EXPECT_NEAR(evaluate(focus), 0.0, 1e-15);
  // By similar triangles from the lens's principal plane through its centre.
  for (const double z : {1.0, 1.2, 2.5})
    EXPECT_NEAR(evaluate(z), std::pow(1.0 - z / focus, 2), 1e-13);
}

// Unpolarised reflectance: normal incidence, Brewster's angle, grazing, a metal.
TEST(Fresnel, KnownValues) {
  EXPECT_NEAR(fresnel_reflectance(1.5, 1.0).value, 0.04, 1e-16);
  const double brewster = std::atan(1.5);
  const double sine = std::pow(std::sin(2.0 * brewster - 0.5 * geometry::kPi), 2);
  EXPECT_NEAR(fresnel_reflectance(1.5, std::cos(brewster)).value, 0.5 * sine, 1e-15);
  EXPECT_NEAR(fresnel_reflectance(1.5, 1e-9).value, 1.0, 1e-8);
  // |(m − 1)/(m + 1)|².
  const std::complex<double> silver(0.05, 4.0);
  EXPECT_NEAR(fresnel_reflectance(silver, 1.0).value, std::norm((silver - 1.0) / (silver + 1.0)),
              1e-15);
}

// Two flat mirrors in a beam: all that falls on the first arrives, less what both absorb.
TEST(Families, FluxIsConserved) {
  SystemSurface first{.name = "first",
                      .shape = geometry::make_plane({0, 0, 0}, {0, 0, 1}),
                      .bounds = geometry::box_aperture({-1, -1, -1}, {1, 1, 1}),
                      .optics = {}};
  SystemSurface second{.name = "second",
                       .shape = geometry::make_plane({2.4, 0, 4}, Vec3(0.3, 0, -1).normalized()),
                       .bounds = geometry::box_aperture({1, -2, 0}, {4, 2, 8}),
                       .optics = {}};
  first.optics.reflectance = 0.9;
  second.optics.reflectance = 0.8;
  const auto receiver = geometry::ReceiverFrame::make({0, 0, -2}, {1, 0, 0}, {0, 1, 0}, {60, 60});
  const auto system = OpticalSystem::build(CollimatedLight{Vec3(0.6, 0, -1).normalized(), 10.0},
                                           {first, second}, receiver);
  ContourRequest request;
  request.families = {{0, 1}};
  const ContourResult result = trace_contours(system, request);
  ASSERT_EQ(result.families.size(), 1u);
  const double expected = 0.9 * 0.8 * 10.0 * 4.0 / std::sqrt(1.36);
  EXPECT_NEAR(result.families[0].flux, expected, 1e-6 * expected);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_EQ(result.warnings[0].code, "uniform_irradiance");
}

// Two mirrored spheres and the light in their plane of symmetry: families come in mirrored pairs.
TEST(Families, MirrorSymmetry) {
  const Optics mirror;
  std::vector<SystemSurface> balls{{.name = "left",
                                    .shape = geometry::make_sphere({-1.2, 0, 0}, 1.0),
                                    .bounds = {},
                                    .optics = mirror},
                                   {.name = "right",
                                    .shape = geometry::make_sphere({1.2, 0, 0}, 1.0),
                                    .bounds = {},
                                    .optics = mirror}};
  const auto receiver = geometry::ReceiverFrame::make({0, 0, -2}, {1, 0, 0}, {0, 1, 0}, {10, 10});
  const auto system = OpticalSystem::build(PointLight{{0, 3, 2}, 1.0}, balls, receiver);
  ContourRequest request;
  request.max_bounces = 3;
  request.levels.values = {1e-5, 1e-4, 1e-3};
  const ContourResult result = trace_contours(system, request);
  const std::vector<std::vector<int>> expected{{0}, {1}, {0, 1}, {1, 0}, {0, 1, 0}, {1, 0, 1}};
  ASSERT_EQ(result.families.size(), expected.size());
  std::vector<double> length(expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(result.families[i].surfaces, expected[i]);
  }
  for (const Curve& c : result.curves) length[c.family_id] += c.length;
  for (std::size_t i = 0; i < expected.size(); i += 2) {
    EXPECT_GT(length[i], 0.0);
    EXPECT_NEAR(length[i], length[i + 1], 1e-2 * length[i]) << i;
    EXPECT_NEAR(result.families[i].flux, result.families[i + 1].flux,
                1e-6 * result.families[i].flux);
  }
}

// Two hollow mirrors of the same sphere's size face each other; of each an aperture leaves a disc
// about as wide as they are apart.
TEST(Families, OfSmallPartsOfLargeSurfacesOccur) {
  for (const double apart : {1.0, 1e-2, 1e-4}) {
    const auto mirror = [&](const char* name, double z) {
      return SystemSurface{
          .name = name,
          .shape = geometry::make_sphere({0.3 * apart, 0, z < 0 ? -50.0 : 50.0 + apart}, 50.0),
          .bounds = geometry::box_aperture({-apart, -apart, -apart}, {apart, apart, 2 * apart}),
          .optics = {}};
    };
    const auto system = OpticalSystem::build(
        PointLight{{0, 0, 0.5 * apart}, 1.0}, {mirror("below", -1), mirror("above", 1)},
        geometry::ReceiverFrame::make({apart, 0, 0.5 * apart}, {0, 1, 0}, {0, 0, 1},
                                      {2 * apart, 0.8 * apart}));
    EXPECT_EQ(families_up_to(system, 2), (std::vector<std::vector<int>>{{0}, {1}, {0, 1}, {1, 0}}))
        << apart;
  }
}

// Surfaces by themselves are families whatever rays find; of several hops only what some ray takes,
// and none where there is no time to follow any.
TEST(Families, OfOneHopNeedNoRays) {
  const auto mirror = [](const char* name, double z) {
    return SystemSurface{.name = name,
                         .shape = geometry::make_plane({0, 0, z}, {0, 0, 1}),
                         .bounds = geometry::box_aperture({-1, -1, z - 1}, {1, 1, z + 1}),
                         .optics = {}};
  };
  const auto system = OpticalSystem::build(
      PointLight{{0, 0, 0.5}, 1.0}, {mirror("below", 0), mirror("above", 1)},
      geometry::ReceiverFrame::make({1.5, 0, 0.5}, {0, 1, 0}, {0, 0, 1}, {4, 4}));
  const std::vector<std::vector<int>> single{{0}, {1}};
  EXPECT_GT(families_up_to(system, 3).size(), single.size());
  const auto stop = [] { return true; };
  EXPECT_EQ(families_up_to(system, 3, Arrival::in_window, stop), single);
  EXPECT_TRUE(families_that_occur(system, 3, Arrival::anywhere, stop).empty());
  EXPECT_TRUE(sides_of(system, {0, 1}, 1, stop).empty());
  EXPECT_FALSE(sides_of(system, {0, 1}, 1).empty());
}

// What a dome sends back of a lamp next to its floor has left the floor from a patch as small as
// the lamp is near.
TEST(Families, OfWhatIsNextToTheLightOccur) {
  for (const double near : {1e-2, 1e-4, 1e-6}) {
    const auto surface = [](const char* name, geometry::SurfacePtr shape, double z) {
      return SystemSurface{.name = name,
                           .shape = std::move(shape),
                           .bounds = geometry::box_aperture({-1, -1, z - 1.1}, {1, 1, z + 1.1}),
                           .optics = {}};
    };
    const auto system = OpticalSystem::build(
        PointLight{{0.3, 0.2, near}, 1.0},
        {surface("floor", geometry::make_plane({0, 0, 0}, {0, 0, 1}), 0),
         surface("dome", geometry::make_sphere({0.3, 0.2, 0}, 0.5), 0)},
        geometry::ReceiverFrame::make({0.3, 0.2, 0.2}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2}));
    const auto found = families_up_to(system, 2);
    EXPECT_NE(std::find(found.begin(), found.end(), std::vector<int>{0, 1}), found.end()) << near;
    EXPECT_FALSE(sides_of(system, {0, 1}, 1).empty()) << near;
  }
}

}  // namespace
}  // namespace caustic::solver
