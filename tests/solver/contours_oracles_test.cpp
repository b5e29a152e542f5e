// Whole traces against scenes whose curves are known.
#include <gtest/gtest.h>

#include <cmath>

#include "solver/contours.h"
#include "tests/support/contour_checks.h"
#include "tests/support/random.h"
#include "tests/support/reference.h"
#include "tests/support/scenes.h"

namespace caustic::solver {
namespace {

using geometry::kPi;
using geometry::Mat2;
using geometry::ReceiverFrame;
using test::floor_at;
using test::one_mirror;
using test::Random;

std::vector<const Curve*> curves_of(const ContourResult& r, CurveKind kind, double level = -1.0) {
  std::vector<const Curve*> found;
  for (const Curve& c : r.curves) {
    if (c.kind == kind && (kind == CurveKind::caustic || c.level == level)) found.push_back(&c);
  }
  return found;
}

// ---- Sphere
// --------------------------------------------------------------------------------------

OpticalSystem case_A1() {
  return one_mirror(PointLight{{0, 0, 4}, 1.0}, geometry::make_sphere(Point::Zero(), 1.0),
                    floor_at({0, 0, 6}, 12, 12));
}

OpticalSystem case_A2() {
  return one_mirror(PointLight{{0, 0, 4}, 1.0}, geometry::make_sphere(Point::Zero(), 1.0),
                    ReceiverFrame::make({3, 0, 1}, {0, 1, 0}, {0, 0, 1}, {8, 8}));
}

// Unit sphere, source at height 4, receiver at height 6: hit at polar angle θ lands at radius r(θ),
// and E = σ sin θ/(r |r'|).
struct A1Profile {
  static long double radius(long double theta) {
    const long double x = sinl(theta), z = cosl(theta);
    const long double dx = x, dz = z - 4.0L, along = dx * x + dz * z;
    const long double ox = dx - 2 * along * x, oz = dz - 2 * along * z;
    return x + (6.0L - z) / oz * ox;
  }
  static long double irradiance(long double theta) {
    const long double h = 1e-5L;
    const long double slope = (8 * (radius(theta + h) - radius(theta - h)) -
                               (radius(theta + 2 * h) - radius(theta - 2 * h))) /
                              (12 * h);
    const long double dx = sinl(theta), dz = cosl(theta) - 4.0L, d2 = dx * dx + dz * dz;
    const long double cosine = (4.0L * cosl(theta) - 1.0L) / sqrtl(d2);
    return cosine / d2 * sinl(theta) / (radius(theta) * fabsl(slope));
  }
  static double radius_at(double level) {
    long double lo = 1e-3L, hi = 1.1L;  // E falls from the axis outwards
    for (int i = 0; i < 100; ++i) {
      const long double middle = (lo + hi) / 2;
      (irradiance(middle) > level ? lo : hi) = middle;
    }
    return static_cast<double>(radius((lo + hi) / 2));
  }
};

TEST(CaseA1, CirclesOfTheKnownRadii) {
  ContourRequest request;
  request.levels.values = {0.0005, 0.0003, 0.00018};
  request.chord_tolerance = 0.0012;
  const auto system = case_A1();
  const auto result = trace_contours(system, request);
  EXPECT_TRUE(result.complete);
  test::expect_sound(system, result, 1e-9, "A1");
  const double known[] = {2.64148155, 4.60955767, 6.40140565};
  ASSERT_EQ(result.curves.size(), 6u);  // two circles, four arcs in the corners, no caustic
  for (int i = 0; i < 3; ++i) {
    const double level = request.levels.values[i], radius = A1Profile::radius_at(level);
    EXPECT_NEAR(radius, known[i], 1e-8);
    const auto curves = curves_of(result, CurveKind::isolux, level);
    ASSERT_EQ(curves.size(), i < 2 ? 1u : 4u);
    for (const Curve* c : curves) {
      EXPECT_EQ(c->closed, i < 2);
      EXPECT_EQ(c->parity, 1);
      EXPECT_EQ(c->ends, std::vector<Ending>(i == 2 ? 2 : 0, Ending::receiver_edge));
      for (const CurveVertex& v : c->vertices) EXPECT_NEAR(v.uv.norm(), radius, 1e-8 * radius);
      EXPECT_LE(test::largest_chord_error(system, *c), request.chord_tolerance);
    }
    EXPECT_TRUE(i == 2 || std::abs(curves[0]->length - 2.0 * kPi * radius) < 0.01);
  }
}

TEST(CaseA2, VerticesAgainstFiftyDigits) {
  ContourRequest request;
  request.levels.values = {0.0015, 0.0008, 0.0005};
  request.chord_tolerance = 0.0008;
  const auto system = case_A2();
  const auto result = trace_contours(system, request);
  test::expect_sound(system, result, 1e-9, "A2");
  const test::ReferenceScene reference{
      .shape = {.name = "ball", .kind = test::ShapeSpec::Kind::sphere, .radius = 1.0},
      .side = 1,
      .reflectance = 1.0,
      .light = system.light(),
      .receiver = system.receiver()};
  EXPECT_GE(result.curves.size(), 3u);
  for (const Curve& c : result.curves) {
    EXPECT_EQ(c.kind, CurveKind::isolux);  // a convex mirror has no caustic
    for (std::size_t i = 0; i < c.vertices.size(); i += 7) {
      const CurveVertex& v = c.vertices[i];
      EXPECT_NEAR(test::reference_irradiance(reference, v.x) / c.level, 1.0, 1e-9);
      EXPECT_NEAR(v.x.norm(), 1.0, 1e-15);
    }
    EXPECT_LE(test::largest_chord_error(system, c), request.chord_tolerance);
  }
}

// ---- Cylinder
// ------------------------------------------------------------------------------------

struct NephroidCase {
  double slope = 1.0;  // of the light, vertical over horizontal
  OpticalSystem system() const {
    return one_mirror(CollimatedLight{Vec3(1, 0, -slope).normalized(), 1.0},
                      geometry::make_cylinder(Point::Zero(), {0, 0, 1}, 1.0),
                      floor_at({0.5, 0, 0}, 1.2, 1.2 * 1.5),
                      geometry::box_aperture({0.5, -1, 0}, {1.001, 1, 2.0 * slope}));
  }
  static Vec2 point(double phi) {
    return {std::cos(phi) - 0.5 * std::cos(phi) * std::cos(2 * phi) - 0.5,
            std::sin(phi) - 0.5 * std::cos(phi) * std::sin(2 * phi)};
  }
};

TEST(Nephroid, EveryVertexTheCuspAndTheEnds) {
  for (const double slope : {1.0, 0.3, 2.5}) {
    const NephroidCase scene{slope};
    const auto system = scene.system();
    ContourRequest request;
    request.levels.values = {1.0, 2.0, 4.0};
    request.chord_tolerance = 1.2e-4;
    const auto result = trace_contours(system, request);
    test::expect_sound(system, result, 1e-9, "nephroid");
    const auto caustics = curves_of(result, CurveKind::caustic);
    ASSERT_EQ(caustics.size(), 1u);
    const Curve& c = *caustics[0];
    EXPECT_FALSE(c.closed);
    EXPECT_EQ(c.ends, std::vector<Ending>(2, Ending::aperture));
    double nearest_to_cusp = 1.0, phi_min = 9.0, phi_max = -9.0;
    for (const CurveVertex& v : c.vertices) {
      const double phi = std::atan2(v.x.y(), v.x.x());
      EXPECT_NEAR((v.uv - NephroidCase::point(phi)).norm(), 0.0, 1e-9) << "phi " << phi;
      EXPECT_NEAR(v.x.z(), 0.5 * std::cos(phi) * slope, 1e-9);
      nearest_to_cusp = std::min(nearest_to_cusp, v.uv.norm());
      phi_min = std::min(phi_min, phi);
      phi_max = std::max(phi_max, phi);
    }
    EXPECT_LT(nearest_to_cusp, 1e-9) << "the cusp at φ = 0 is a vertex";
    EXPECT_NEAR(phi_min, -kPi / 3, 1e-9);
    EXPECT_NEAR(phi_max, kPi / 3, 1e-9);
    EXPECT_LE(test::largest_chord_error(system, c), request.chord_tolerance);
  }
}

TEST(Cardioid, SourceOnTheWall) {
  for (const double height : {2.0, 0.8}) {
    const auto system = one_mirror(PointLight{{1, 0, height}, 1.0},
                                   geometry::make_cylinder(Point::Zero(), {0, 0, 1}, 1.0),
                                   floor_at(Point::Zero(), 3, 3),
                                   geometry::box_aperture({-1.001, -1.001, 0}, {0.9, 1.001, 3}));
    ContourRequest request;
    request.isolux = false;
    const auto result = trace_contours(system, request);
    test::expect_sound(system, result, 1e-9, "cardioid");
    const auto caustics = curves_of(result, CurveKind::caustic);
    ASSERT_EQ(caustics.size(), 1u);
    const Curve& c = *caustics[0];
    EXPECT_EQ(c.ends, std::vector<Ending>(2, Ending::aperture));
    double nearest_to_cusp = 1.0;
    for (const CurveVertex& v : c.vertices) {
      const double phi = std::atan2(v.x.y(), v.x.x());
      const Vec2 known =
          Vec2(2 * std::cos(phi) + std::cos(2 * phi), 2 * std::sin(phi) + std::sin(2 * phi)) / 3.0;
      EXPECT_NEAR((v.uv - known).norm(), 0.0, 1e-9) << "phi " << phi;
      EXPECT_NEAR(v.x.z(), 0.25 * height, 1e-9);
      nearest_to_cusp = std::min(nearest_to_cusp, (v.uv - Vec2(-1.0 / 3.0, 0)).norm());
    }
    EXPECT_LT(nearest_to_cusp, 1e-9);
    EXPECT_NEAR(std::abs(std::atan2(c.vertices.front().x.y(), c.vertices.front().x.x())),
                std::acos(0.9), 1e-9);
  }
}

// ---- Plane and paraboloid
// ------------------------------------------------------------------------

TEST(PlaneMirror, CirclesAboutTheFootOnAnyReceiver) {
  Random random(11);
  int circles = 0;
  for (int scene = 0; scene < 30; ++scene) {
    const Point source(0.3, -0.2, 2.0);
    const geometry::Normal normal(0, 0, 1);
    const Point image(0.3, -0.2, -2.0);
    const Vec3 u = random.direction(), v = random.direction();
    const auto receiver = ReceiverFrame::make(Point(0.5, 0.5, 3.5), u, v, {5.0, 4.0});
    const double h = std::abs(receiver.m.dot(image - receiver.origin));
    if (h < 1.5) continue;
    const auto system =
        one_mirror(PointLight{source, 3.0}, geometry::make_plane(Point::Zero(), normal), receiver,
                   geometry::box_aperture({-9, -9, -1}, {9, 9, 1}), 0.8);
    const Point foot = image - receiver.m * receiver.m.dot(image - receiver.origin);
    ContourRequest request;
    request.levels.values = {};
    for (const double r : {0.7, 1.6, 2.6}) {
      request.levels.values.push_back(0.8 * 3.0 * h / std::pow(h * h + r * r, 1.5));
    }
    const auto result = trace_contours(system, request);
    test::expect_sound(system, result, 1e-9, "plane mirror");
    EXPECT_TRUE(curves_of(result, CurveKind::caustic).empty());
    for (const Curve& c : result.curves) {
      for (const CurveVertex& vertex : c.vertices) {
        const double r = std::sqrt(std::pow(0.8 * 3.0 * h / c.level, 2.0 / 3.0) - h * h);
        EXPECT_NEAR((vertex.p - foot).norm(), r, 1e-8);
      }
      ++circles;
    }
  }
  EXPECT_GT(circles, 20);
}

TEST(Paraboloid, CirclesOfABeam) {
  const double focal = 0.7;
  const auto system = one_mirror(
      PointLight{{0, 0, focal}, 2.0},
      geometry::make_conic(Point::Zero(), Vec3::UnitZ(), 2.0 * focal, -1.0, {}),
      floor_at({0, 0, 5}, 4, 4), {geometry::cylinder_aperture(Point::Zero(), {0, 0, 1}, 1.9)});
  ContourRequest request;
  for (const double r : {0.2, 0.9, 1.5, 1.85}) {
    request.levels.values.push_back(2.0 * 16 * focal * focal /
                                    std::pow(4 * focal * focal + r * r, 2));
  }
  const auto result = trace_contours(system, request);
  test::expect_sound(system, result, 1e-9, "paraboloid");
  ASSERT_EQ(result.curves.size(), 4u);
  const double radii[] = {1.85, 1.5, 0.9, 0.2};  // by ascending level
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(result.curves[i].closed);
    for (const CurveVertex& v : result.curves[i].vertices) {
      EXPECT_NEAR(v.uv.norm(), radii[i], 1e-8);
    }
  }
}

// ---- Energy
// --------------------------------------------------------------------------------------

// Gauss–Legendre nodes and weights on [0, 1].
std::vector<std::pair<double, double>> gauss(int n) {
  std::vector<std::pair<double, double>> rule;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(kPi * (i + 0.75) / (n + 0.5)), slope = 0.0;
    for (int step = 0; step < 100; ++step) {
      double p0 = 1.0, p1 = x;
      for (int k = 2; k <= n; ++k) {
        const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p2;
      }
      slope = n * (x * p1 - p0) / (x * x - 1.0);
      x -= p1 / slope;
    }
    rule.push_back({0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope)});
  }
  return rule;
}

// x on the mirror whose light arrives at q, followed from a start by small steps.
Point hit_for(const ForwardMap& map, Point x, const Vec2& q) {
  const Vec2 from = map.evaluate(x).q;
  for (int piece = 1; piece <= 8; ++piece) {
    const Vec2 target = from + (piece / 8.0) * (q - from);
    for (int i = 0; i < 8; ++i) {
      const FieldPoint f = map.evaluate(x);
      Mat2 M;
      M << f.q_s, f.q_t;
      const Vec2 step = M.inverse() * (target - f.q);
      x = map.project(x + step.x() * f.e1 + step.y() * f.e2);
    }
  }
  return x;
}

struct EnergyCase {
  const char* name;
  OpticalSystem system;
  int side;
  Point start;  // a hit that arrives in the receiver
};

TEST(Energy, IrradianceOnTheReceiverIsFluxOnTheMirror) {
  const Point source(0.3, 0.2, 4);
  std::vector<EnergyCase> cases;
  cases.push_back({"sphere",
                   one_mirror(PointLight{source, 2.0}, geometry::make_sphere(Point::Zero(), 1.0),
                              floor_at({0.5, -0.3, 6}, 5, 4), {}, 0.9),
                   1,
                   {0, 0, 1}});
  cases.push_back({"ellipsoid",
                   one_mirror(PointLight{source, 2.0},
                              geometry::make_ellipsoid(Point::Zero(), {1.5, 0.8, 1.0},
                                                       geometry::Mat3::Identity()),
                              floor_at({0.5, -0.3, 6}, 5, 4), {}, 0.9),
                   1,
                   {0, 0, 1}});
  cases.push_back({"paraboloid",
                   one_mirror(PointLight{{0.05, 0.02, 0.5}, 2.0},
                              geometry::make_conic(Point::Zero(), {0, 0, 1}, 1.4, -1, {}),
                              floor_at({0.2, 0, 2}, 1.6, 1.2), {}, 0.9),
                   1, Point::Zero()});
  cases.push_back(
      {"asphere",
       one_mirror(PointLight{{0.05, 0.02, 0.5}, 2.0},
                  geometry::make_conic(Point::Zero(), {0, 0, 1}, 1.4, -1, {0.03, -0.01}),
                  floor_at({0.2, 0, 2}, 1.6, 1.2), {}, 0.9),
       1, Point::Zero()});
  for (EnergyCase& c : cases) {
    const ForwardMap map(c.system, 0, c.side);
    const auto& receiver = c.system.receiver();
    const double intensity = std::get<PointLight>(c.system.light()).intensity;
    const Point light = std::get<PointLight>(c.system.light()).position;
    const auto rule = gauss(24);

    double on_receiver = 0.0;
    for (const auto& [s, ws] : rule) {
      for (const auto& [t, wt] : rule) {
        const Vec2 q(receiver.half.x() * (2 * s - 1), receiver.half.y() * (2 * t - 1));
        const FieldPoint f = map.evaluate(hit_for(map, c.start, q));
        ASSERT_LT((f.q - q).norm(), 1e-10) << c.name;
        on_receiver += ws * wt * 4.0 * receiver.half.prod() * f.irradiance();
      }
    }

    // ∫ρσ dS = ρI × the solid angle of the receiver's image on the mirror, by Stokes' theorem along
    // its edge: ∮(1 − cos θ) dφ about a direction inside.
    const Direction pole = (map.project(hit_for(map, c.start, Vec2::Zero())) - light).normalized();
    const geometry::Frame frame(pole);
    const auto line_rule = gauss(60);
    double solid = 0.0;
    const Vec2 corners[] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (int edge = 0; edge < 4; ++edge) {
      const Vec2 a = corners[edge], b = corners[(edge + 1) % 4];
      for (const auto& [w, weight] : line_rule) {
        const Vec2 q = (a + w * (b - a)).cwiseProduct(receiver.half);
        const Vec2 dq = (b - a).cwiseProduct(receiver.half);
        const FieldPoint f = map.evaluate(hit_for(map, c.start, q));
        Mat2 M;
        M << f.q_s, f.q_t;
        const Vec2 st = M.inverse() * dq;
        const Vec3 d = f.x - light, dd = st.x() * f.e1 + st.y() * f.e2;
        const double x = frame.e1.dot(d), y = frame.e2.dot(d);
        const double dphi = (x * frame.e2.dot(dd) - y * frame.e1.dot(dd)) / (x * x + y * y);
        solid += weight * (1.0 - pole.dot(d) / d.norm()) * dphi;
      }
    }
    const double on_mirror = 0.9 * intensity * std::abs(solid);
    EXPECT_NEAR(on_receiver / on_mirror, 1.0, 1e-8) << c.name;

    ContourRequest request;
    request.isolux = false;
    const auto result = trace_contours(c.system, request);
    EXPECT_NEAR(result.families[0].flux / on_mirror, 1.0, 0.01) << c.name;
  }
}

}  // namespace
}  // namespace caustic::solver
