// The forward map against scenes with known answers and against other roads to the same numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "solver/forward_map.h"
#include "tests/support/reference.h"
#include "tests/support/sampling.h"

namespace caustic::solver {
namespace {

using geometry::kPi;
using geometry::Mat2;
using geometry::ReceiverFrame;
using test::Random;
using test::ShapeSpec;
using Kind = ShapeSpec::Kind;

OpticalSystem unbounded_mirror(Light light, geometry::SurfacePtr shape,
                               const ReceiverFrame& receiver, double reflectance = 1.0) {
  SystemSurface surface{.name = "mirror", .shape = std::move(shape), .bounds = {}, .optics = {}};
  surface.optics.reflectance = reflectance;
  return OpticalSystem::build(std::move(light), {surface}, receiver);
}

ReceiverFrame random_receiver(Random& random) {
  return ReceiverFrame::make(random.in_cube(4.0), random.direction(), random.direction(), {5, 5});
}

// A lit point whose ray arrives at a fair angle, of all shapes but planes.
bool fair(const ForwardMap& map, const FieldPoint& f) {
  return f.arrives() && f.cos_alpha > 0.05 && f.lambda > 0.05 &&
         std::abs(f.facing) > 0.05 * map.incident(f.x).norm();
}

TEST(Plane, ReflectsLikeAMirroredSource) {
  Random random(1);
  int checked = 0;
  for (int scene = 0; scene < 50; ++scene) {
    const Point source = random.in_cube(3.0), on_plane = random.in_cube(3.0);
    const geometry::Normal normal = random.direction();
    const double intensity = random.uniform(0.5, 5.0), rho = random.uniform(0.3, 1.0);
    const auto receiver = random_receiver(random);
    const auto system = unbounded_mirror(PointLight{source, intensity},
                                         geometry::make_plane(on_plane, normal), receiver, rho);
    const int side = normal.dot(source - on_plane) > 0.0 ? 1 : -1;
    const ForwardMap map(system, 0, side);
    const Point image = source - 2.0 * normal.dot(source - on_plane) * normal;
    const double h = std::abs(receiver.m.dot(image - receiver.origin));
    for (const Point& x :
         test::sample_surface(map.shape(), test::extent_about(on_plane, 4.0), 50, random)) {
      const FieldPoint f = map.evaluate(x);
      EXPECT_TRUE(f.lit());
      if (!fair(map, f)) continue;
      const Point foot = image - receiver.m * receiver.m.dot(image - receiver.origin);
      const double r2 = (receiver.point(f.q) - foot).squaredNorm();
      const double expected = rho * intensity * h / std::pow(h * h + r2, 1.5);
      EXPECT_NEAR(f.irradiance() / expected, 1.0, 1e-11);
      ++checked;
    }
  }
  EXPECT_GT(checked, 500);
}

// (S8): curvatures of the reflected wavefront at x. V is its divergence, ∂ω'/∂y across the ray:
// across the plane of incidence V = 1/d₁ + 2 cos α κ, in it 1/d₁ + 2κ/cos α, mixed 2κ.
double irradiance_by_wavefront(const ShapeSpec& spec, const Light& light, int side,
                               const ReceiverFrame& receiver, const Point& x) {
  const auto shape = test::reference_shape(spec, x);
  const Vec3 n = side * shape.normal;
  const geometry::Mat3 dn = side * shape.curvature;
  Vec3 in;
  double spread = 0.0, flux = 0.0;  // of the incoming wavefront: divergence, irradiance across it
  if (const auto* point = std::get_if<PointLight>(&light)) {
    in = x - point->position;
    spread = 1.0 / in.norm();
    flux = point->intensity * spread * spread;
    in.normalize();
  } else {
    in = std::get<CollimatedLight>(light).direction;
    flux = std::get<CollimatedLight>(light).irradiance;
  }
  const double cos_alpha = -in.dot(n);
  const Vec3 out = in + 2.0 * cos_alpha * n;
  const Vec3 across = n.cross(in).normalized(), along = n.cross(across);
  const double d2 = receiver.m.dot(receiver.origin - x) / receiver.m.dot(out);
  Mat2 V;
  V(0, 0) = spread + 2.0 * cos_alpha * across.dot(dn * across);
  V(1, 1) = spread + 2.0 * along.dot(dn * along) / cos_alpha;
  V(0, 1) = V(1, 0) = 2.0 * across.dot(dn * along);
  const double cos_arrival = std::abs(receiver.m.dot(out));
  return flux * cos_arrival / std::abs((Mat2::Identity() + d2 * V).determinant());
}

TEST(Wavefront, CurvaturesGiveTheSameIrradiance) {
  Random random(2);
  for (const ShapeSpec& spec : test::shape_zoo()) {
    int checked = 0;
    for (int scene = 0; scene < 20; ++scene) {
      Light light = CollimatedLight{random.direction(), 3.0};
      if (scene % 2 == 0) light = PointLight{random.in_cube(4.0), 2.0};
      const auto receiver = random_receiver(random);
      const auto system = unbounded_mirror(light, test::build(spec), receiver);
      const ForwardMap map(system, 0, scene % 4 < 2 ? 1 : -1);
      for (const Point& x : test::sample_surface(
               map.shape(), test::extent_about(spec.pose.translation, 3.0), 10, random)) {
        const FieldPoint f = map.evaluate(x);
        if (!fair(map, f) || std::abs(f.a) < 0.01 * f.scale_of_a()) continue;
        if (!geometry::exists_at(map.shape().own_bounds(), x, -1e-3)) continue;
        const double expected = irradiance_by_wavefront(spec, light, map.side(), receiver, x);
        EXPECT_NEAR(f.irradiance() / expected, 1.0, 1e-9) << spec.name;
        ++checked;
      }
    }
    EXPECT_GT(checked, 10) << spec.name;
  }
}

// Chen (4.20) as printed compares curvatures at p across rays; it must not pass.
TEST(Sphere, IrradianceOnTheAxis) {
  // Unit sphere, source at height s, receiver at height z above its centre: on the axis the image
  // lies 1/(2 + 1/(s − 1)) below the pole.
  for (const double s : {1.5, 4.0, 50.0}) {
    for (const double z : {2.0, 6.0}) {
      const auto receiver = ReceiverFrame::make({0, 0, z}, {1, 0, 0}, {0, 1, 0}, {12, 12});
      const auto system = unbounded_mirror(PointLight{{0, 0, s}, 1.0},
                                           geometry::make_sphere(Point::Zero(), 1.0), receiver);
      const FieldPoint f = ForwardMap(system, 0, 1).evaluate({0, 0, 1});
      const double d1 = s - 1.0, d2 = z - 1.0, spread = 1.0 / d1 + 2.0;
      const double expected = 1.0 / std::pow(d1 * (1.0 + d2 * spread), 2);
      EXPECT_NEAR(f.irradiance() / expected, 1.0, 1e-14);
      EXPECT_NEAR(f.irradiance_gradient().norm(), 0.0, 1e-14 * expected);
      EXPECT_GT(f.a, 0.0);
    }
  }
}

TEST(Paraboloid, SourceInTheFocusMakesABeam) {
  Random random(3);
  const double focal = 0.7, rho = 0.9, intensity = 2.5;
  // z = r²/(4f): as a conic, and as a quadric x² + y² − 4fz.
  const geometry::SurfacePtr shapes[] = {
      geometry::make_conic(Point::Zero(), Vec3::UnitZ(), 2.0 * focal, -1.0, {}),
      geometry::make_quadric({1, 1, 0, 0, 0, 0, 0, 0, -2.0 * focal, 0}, {}).surface,
      geometry::make_conic(Point::Zero(), Vec3::UnitZ(), 2.0 * focal, -1.0, {0.0, 0.0})};
  const auto receiver = ReceiverFrame::make({0, 0, 5}, {1, 0, 0}, {0, 1, 0}, {4, 4});
  for (const auto& shape : shapes) {
    const auto system =
        unbounded_mirror(PointLight{{0, 0, focal}, intensity}, shape, receiver, rho);
    // The light is where the conic has g > 0 and the quadric g < 0.
    const int side = shape->value({0, 0, focal}) > 0.0 ? 1 : -1;
    const ForwardMap map(system, 0, side);
    for (int i = 0; i < 200; ++i) {
      const Vec2 q(random.uniform(-2, 2), random.uniform(-2, 2));
      const double r2 = q.squaredNorm();
      const FieldPoint f = map.evaluate({q.x(), q.y(), r2 / (4.0 * focal)});
      EXPECT_NEAR((f.q - q).norm(), 0.0, 1e-14);
      const double denominator = 4.0 * focal * focal + r2;
      const double expected = rho * intensity * 16.0 * focal * focal / (denominator * denominator);
      EXPECT_NEAR(f.irradiance() / expected, 1.0, 1e-13);
      const Vec2 gradient = -4.0 * expected / denominator * q;
      EXPECT_NEAR((f.irradiance_gradient() - gradient).norm(), 0.0, 1e-12 * expected / focal);
      EXPECT_TRUE(f.arrives() && f.lit());
    }
  }
}

TEST(Ellipsoid, FocusToFocusHasNoMagnification) {
  Random random(4);
  const double a = 2.0, b = 1.2, c = std::sqrt(a * a - b * b);
  const auto receiver = ReceiverFrame::make({c, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1});
  const auto system = unbounded_mirror(
      PointLight{{-c, 0, 0}, 1.0},
      geometry::make_ellipsoid(Point::Zero(), {a, b, b}, geometry::Mat3::Identity()), receiver);
  const ForwardMap map(system, 0, -1);
  for (const Point& x :
       test::sample_surface(map.shape(), test::extent_about(Point::Zero(), 3.0), 200, random)) {
    const FieldPoint f = map.evaluate(x);
    // Off by rounding over the sine of arrival.
    const double arrival = std::abs(f.facing) / map.incident(x).norm();
    if (arrival < 1e-2) continue;
    EXPECT_LT(f.q.norm(), 1e-14 / arrival);
    EXPECT_LT(std::max(f.q_s.norm(), f.q_t.norm()), 1e-13 / (arrival * arrival));
  }
}

// x with map(x).q = q, by Newton's method from a start nearby.
std::optional<Point> inverse(const ForwardMap& map, const Point& start, const Vec2& q) {
  Point x = start;
  for (int i = 0; i < 30; ++i) {
    const FieldPoint f = map.evaluate(x);
    if (!f.finite) return {};
    Mat2 M;
    M << f.q_s, f.q_t;
    const Vec2 step = M.inverse() * (q - f.q);
    x = map.project(x + step.x() * f.e1 + step.y() * f.e2);
    if (step.norm() < 1e-14) return x;
  }
  return (map.evaluate(x).q - q).norm() < 1e-11 ? std::optional(x) : std::nullopt;
}

TEST(IrradianceGradient, MatchesDifferencesOnTheReceiver) {
  Random random(5);
  for (const ShapeSpec& spec : test::shape_zoo()) {
    int checked = 0;
    for (int scene = 0; scene < 30; ++scene) {
      Light light = CollimatedLight{random.direction(), 3.0};
      if (scene % 2 == 0) light = PointLight{random.in_cube(4.0), 2.0};
      const auto system = unbounded_mirror(light, test::build(spec), random_receiver(random));
      const ForwardMap map(system, 0, scene % 4 < 2 ? 1 : -1);
      for (const Point& x : test::sample_surface(
               map.shape(), test::extent_about(spec.pose.translation, 2.0), 4, random)) {
        const FieldPoint f = map.evaluate(x);
        if (!fair(map, f) || std::abs(f.a) < 0.2 * f.scale_of_a()) continue;
        if (!geometry::exists_at(map.shape().own_bounds(), x, -0.05)) continue;
        // Stay within a small part of the length over which M changes.
        const double h = 1e-3 * f.scale_of_a() / (f.grad_a.norm() + f.scale_of_a()) *
                         std::min(1.0, std::min(f.q_s.norm(), f.q_t.norm()));
        const auto irradiance = [&](const Vec2& dq) -> double {
          const auto y = inverse(map, x, f.q + dq);
          return y ? map.evaluate(*y).irradiance() : std::nan("");
        };
        const auto differences = [&](double step) {
          Vec2 d;
          for (int i = 0; i < 2; ++i) {
            const Vec2 e = step * Vec2::Unit(i);
            d[i] = (8.0 * (irradiance(e) - irradiance(-e)) -
                    (irradiance(2.0 * e) - irradiance(-2.0 * e))) /
                   (12.0 * step);
          }
          return d;
        };
        // Two steps tell how far the differences themselves can be trusted.
        const Vec2 coarse = differences(h), fine = differences(0.5 * h);
        const double doubt = (coarse - fine).norm(), scale = f.irradiance() / (1e3 * h);
        if (!(doubt < 1e-5 * scale)) continue;
        EXPECT_LT((fine - f.irradiance_gradient()).norm(), doubt + 1e-8 * scale)
            << spec.name << " gradient " << f.irradiance_gradient().transpose();
        ++checked;
      }
    }
    EXPECT_GT(checked, 5) << spec.name;
  }
}

TEST(FieldPoint, DerivativesAlongTheSurface) {
  Random random(6);
  for (const ShapeSpec& spec : test::shape_zoo()) {
    const auto system = unbounded_mirror(PointLight{random.in_cube(3.0), 2.0}, test::build(spec),
                                         random_receiver(random));
    const ForwardMap map(system, 0, 1);
    for (const Point& x : test::sample_surface(
             map.shape(), test::extent_about(spec.pose.translation, 2.0), 20, random)) {
      const FieldPoint f = map.evaluate(x);
      if (std::abs(f.facing) < 0.2 * map.incident(x).norm() || map.incident(x).norm() < 0.5)
        continue;
      if (!geometry::exists_at(map.shape().own_bounds(), x, -0.1)) continue;
      if (std::abs(f.cos_alpha) < 0.1) continue;
      const double bend = test::reference_shape(spec, x).curvature.norm();
      if (bend > 10.0) continue;
      const Vec3 step = 1e-5 * (std::cos(0.7) * f.e1 + std::sin(0.7) * f.e2);
      const FieldPoint hi = map.evaluate(map.project(x + step));
      const FieldPoint lo = map.evaluate(map.project(x - step));
      const double scale = step.norm() * (1.0 + bend) * (1.0 + bend);
      EXPECT_NEAR((0.5 * (hi.q - lo.q) - f.push_forward(step)).norm(), 0.0,
                  1e-6 * scale * std::sqrt(f.scale_of_a() + 1.0));
      EXPECT_NEAR(0.5 * (hi.cos_alpha - lo.cos_alpha), f.grad_cos.dot(step), 1e-6 * scale);
      EXPECT_NEAR(0.5 * (hi.flux - lo.flux), f.grad_flux.dot(step), 1e-5 * scale);
      const double phi_scale = scale * (f.grad_a.norm() + f.scale_of_a()) / std::abs(f.flux);
      EXPECT_NEAR(0.5 * (hi.inverse_irradiance() - lo.inverse_irradiance()),
                  f.inverse_irradiance_gradient().dot(step), 1e-5 * phi_scale);
      EXPECT_NEAR((map.arrival(x) - f.q).norm(), 0.0, 1e-13 * (1.0 + f.q.norm()));
      EXPECT_NEAR(f.grad_a.dot(f.n), 0.0, 1e-14 * f.grad_a.norm());
    }
  }
}

TEST(Project, ReachesTheSurfaceToRounding) {
  Random random(7);
  for (const double size : {1e-6, 1.0, 1e6}) {
    for (const ShapeSpec& given : test::shape_zoo()) {
      const ShapeSpec spec = test::scaled(given, size);
      const auto receiver =
          ReceiverFrame::make(Point(0, 0, -2 * size), {1, 0, 0}, {0, 1, 0}, {size, size});
      const auto system =
          unbounded_mirror(CollimatedLight{{0, 0, -1}, 1.0}, test::build(spec), receiver);
      const ForwardMap map(system, 0, 1);
      for (const Point& x : test::sample_surface(
               map.shape(), test::extent_about(spec.pose.translation, 2.0 * size), 20, random)) {
        if (!geometry::exists_at(map.shape().own_bounds(), x, -0.1 * size)) continue;
        if (test::reference_shape(spec, x).curvature.norm() * size > 10.0) continue;
        const Point y = map.project(x + random.in_cube(1e-3 * size));
        EXPECT_LT((y - x).norm(), 3e-3 * size) << spec.name;
        EXPECT_LT(std::abs(test::reference_shape(spec, y).distance), 4.0 * map.rounding(y))
            << spec.name;
      }
    }
  }
}

// Lengths times f: a stays, gradients of a go with 1/f, flux density of a point source with 1/f².
TEST(FieldPoint, ScalesWithTheScene) {
  Random random(8);
  for (const ShapeSpec& spec : test::shape_zoo()) {
    const Point source = random.in_cube(3.0), origin = random.in_cube(3.0);
    const Vec3 u = random.direction(), v = random.direction();
    const auto system = unbounded_mirror(PointLight{source, 1.0}, test::build(spec),
                                         ReceiverFrame::make(origin, u, v, {2, 2}));
    const ForwardMap map(system, 0, 1);
    const auto points = test::sample_surface(
        map.shape(), test::extent_about(spec.pose.translation, 2.0), 20, random);
    for (const double size : {1e-6, 1e6}) {
      const auto large =
          unbounded_mirror(PointLight{size * source, 1.0}, test::build(test::scaled(spec, size)),
                           ReceiverFrame::make(size * origin, u, v, {2 * size, 2 * size}));
      const ForwardMap large_map(large, 0, 1);
      for (const Point& x : points) {
        if (!geometry::exists_at(map.shape().own_bounds(), x, -0.05)) continue;
        if (test::reference_shape(spec, x).curvature.norm() > 10.0) continue;
        const FieldPoint f = map.evaluate(x), g = large_map.evaluate(size * x);
        ASSERT_TRUE(g.finite);
        if (std::abs(f.facing) < 0.05 * map.incident(x).norm()) continue;
        EXPECT_NEAR((g.q / size - f.q).norm(), 0.0, 1e-12 * (1.0 + f.q.norm())) << spec.name;
        EXPECT_NEAR(g.a / f.scale_of_a(), f.a / f.scale_of_a(), 1e-11) << spec.name;
        EXPECT_NEAR((g.grad_a * size - f.grad_a).norm(), 0.0,
                    1e-11 * (f.grad_a.norm() + f.scale_of_a()))
            << spec.name;
        EXPECT_NEAR(g.flux * size * size, f.flux, 1e-12 / std::pow((x - source).norm(), 2));
      }
    }
  }
}

TEST(FieldPoint, SaysWhereItIsNotDefined) {
  const auto receiver = ReceiverFrame::make({0, 0, -1}, {1, 0, 0}, {0, 1, 0}, {2, 2});
  // The light on the mirror itself.
  const auto on_mirror = unbounded_mirror(PointLight{{0, 0, 1}, 1.0},
                                          geometry::make_sphere(Point::Zero(), 1.0), receiver);
  EXPECT_FALSE(ForwardMap(on_mirror, 0, 1).evaluate({0, 0, 1}).finite);
  // A cone's apex has no normal.
  const auto cone = unbounded_mirror(PointLight{{0, 0, 3}, 1.0},
                                     geometry::make_cone(Point::Zero(), {0, 0, 1}, 0.5), receiver);
  EXPECT_FALSE(ForwardMap(cone, 0, 1).evaluate(Point::Zero()).finite);
  // A ray that leaves along the receiver's plane.
  const auto parallel =
      unbounded_mirror(CollimatedLight{{0, 0, -1}, 1.0},
                       geometry::make_plane(Point::Zero(), Vec3(1, 0, 1).normalized()), receiver);
  const FieldPoint f = ForwardMap(parallel, 0, 1).evaluate(Point::Zero());
  EXPECT_FALSE(f.arrives() && std::abs(f.facing) == 0.0);
  // Away from the receiver.
  const auto away = unbounded_mirror(CollimatedLight{{0, 0, -1}, 1.0},
                                     geometry::make_plane(Point::Zero(), {0, 0, 1}), receiver);
  EXPECT_FALSE(ForwardMap(away, 0, 1).evaluate(Point::Zero()).arrives());
  EXPECT_TRUE(ForwardMap(away, 0, 1).evaluate(Point::Zero()).lit());
  EXPECT_FALSE(ForwardMap(away, 0, -1).evaluate(Point::Zero()).lit());
}

}  // namespace
}  // namespace caustic::solver
