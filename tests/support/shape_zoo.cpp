#include "tests/support/shape_zoo.h"

#include <cmath>
#include <cstdio>
#include <ostream>
#include <stdexcept>

#include "geometry/expression/field.h"
#include "tests/support/random.h"

namespace caustic::test {

using geometry::Mat3;
using geometry::Point;
using geometry::Vec3;
using Kind = ShapeSpec::Kind;

std::ostream& operator<<(std::ostream& out, const ShapeSpec& spec) { return out << spec.name; }

geometry::SurfacePtr build(const ShapeSpec& s) {
  const Point point = s.pose.point(s.point);
  const geometry::Direction axis = s.pose.direction(s.axis);
  switch (s.kind) {
    case Kind::plane: return geometry::make_plane(point, axis);
    case Kind::sphere: return geometry::make_sphere(point, s.radius);
    case Kind::ellipsoid:
      return geometry::make_ellipsoid(point, s.semi_axes, s.pose.rotation * s.rotation);
    case Kind::cylinder: return geometry::make_cylinder(point, axis, s.radius);
    case Kind::cone: return geometry::make_cone(point, axis, s.radius);
    case Kind::torus: return geometry::make_torus(point, axis, s.radius, s.second);
    case Kind::conic: return geometry::make_conic(point, axis, s.radius, s.second, s.aspheric);
    case Kind::revolution: return geometry::make_revolution(point, axis, s.radius, s.profile).surface;
    case Kind::sag: {
      geometry::XyPolynomial f;
      for (const auto& [i, j, c] : s.terms) f.add(i, j, c);
      return geometry::make_sag(point, s.pose.rotation * s.rotation, f);
    }
    case Kind::zernike:
      return geometry::make_sag(point, s.pose.rotation * s.rotation,
                                geometry::zernike(s.zernike, s.radius));
    case Kind::heights: return geometry::make_sag(point, s.pose.rotation * s.rotation, s.grid);
    case Kind::expression: {
      const auto made = geometry::make_expression(geometry::read_expression(s.expression, s.unit),
                                                  geometry::Box::around(Point::Zero(), s.radius),
                                                  s.pose);
      if (!made.surface) throw std::runtime_error(s.name + ": " + made.fault);
      return made.surface;
    }
    case Kind::quadric: break;
  }
  const auto result = geometry::make_quadric(s.coefficients, s.pose);
  if (!result.surface) throw std::runtime_error(s.name + ": " + result.fault);
  return result.surface;
}

std::array<double, 10> quadric_coefficients(const Vec3& lambda, double linear, double constant,
                                            const Mat3& axes, const Point& origin) {
  const Mat3 Q = axes * lambda.asDiagonal() * axes.transpose();
  const Vec3 along = linear * axes.col(2);
  const Vec3 G = along - Q * origin;
  const double J = origin.dot(Q * origin) - 2.0 * along.dot(origin) + constant;
  return {Q(0, 0), Q(1, 1), Q(2, 2), Q(0, 1), Q(0, 2), Q(1, 2), G.x(), G.y(), G.z(), J};
}

namespace {

struct QuadricClass {
  const char* name;
  Vec3 lambda;
  double linear, constant;
};

std::vector<ShapeSpec> make_zoo() {
  Random random(20260);
  std::vector<ShapeSpec> zoo;
  const auto add = [&](ShapeSpec s) {
    s.point = random.in_cube(0.5);
    s.axis = random.direction();
    s.pose = geometry::Pose::make(random.direction(), random.uniform(0.3, 3.0), random.in_cube(0.7));
    zoo.push_back(std::move(s));
  };

  add({.name = "plane", .kind = Kind::plane});
  add({.name = "sphere", .kind = Kind::sphere, .radius = 1.1});
  add({.name = "ellipsoid", .kind = Kind::ellipsoid, .rotation = random.rotation(),
       .semi_axes = {1.3, 0.8, 0.5}});
  add({.name = "cylinder", .kind = Kind::cylinder, .radius = 0.9});
  add({.name = "cone_narrow", .kind = Kind::cone, .radius = 0.4});
  add({.name = "cone_wide", .kind = Kind::cone, .radius = 1.25});
  add({.name = "torus_thin", .kind = Kind::torus, .radius = 1.2, .second = 0.2});
  add({.name = "torus_fat", .kind = Kind::torus, .radius = 0.9, .second = 0.8});

  const QuadricClass classes[] = {
      {"quadric_ellipsoid", {1.0, 2.0, 4.0}, 0.0, -1.2},
      {"quadric_one_sheet", {1.0, 2.0, -1.5}, 0.0, -0.8},
      {"quadric_two_sheets", {1.0, 2.0, -1.5}, 0.0, 0.8},
      {"quadric_cone", {1.0, 2.0, -1.5}, 0.0, 0.0},
      {"quadric_elliptic_paraboloid", {1.0, 2.0, 0.0}, -0.7, 0.3},
      {"quadric_hyperbolic_paraboloid", {1.0, -2.0, 0.0}, -0.7, 0.3},
      {"quadric_elliptic_cylinder", {1.0, 2.0, 0.0}, 0.0, -0.9},
      {"quadric_hyperbolic_cylinder", {1.0, -2.0, 0.0}, 0.0, -0.9},
      {"quadric_parabolic_cylinder", {1.5, 0.0, 0.0}, 0.6, 0.2},
      {"quadric_parallel_planes", {1.5, 0.0, 0.0}, 0.0, -0.7},
      {"quadric_single_plane", {0.0, 0.0, 0.0}, 0.8, 0.4},
  };
  for (const QuadricClass& c : classes) {
    for (const double sign : {1.0, -1.0}) {
      ShapeSpec s{.name = std::string(c.name) + (sign < 0.0 ? "_negated" : ""),
                  .kind = Kind::quadric};
      s.coefficients = quadric_coefficients(sign * c.lambda, sign * c.linear, sign * c.constant,
                                            random.rotation(), random.in_cube(0.5));
      add(std::move(s));
    }
  }

  const auto number = [](double k) {
    const std::string magnitude = std::to_string(static_cast<int>(std::lround(10.0 * std::abs(k))));
    return (k < 0.0 ? "minus" : "") + magnitude;
  };
  for (const double R : {1.5, -1.5}) {
    for (const double k : {-2.5, -1.0, -0.4, 0.0, 0.8}) {
      const std::string name = "k_" + number(k) + "_R_" + number(R);
      add({.name = "conic_" + name, .kind = Kind::conic, .radius = R, .second = k});
      if (k == 0.0) continue;
      add({.name = "asphere_" + name, .kind = Kind::conic, .radius = R, .second = k,
           .aspheric = {0.05, -0.02, 0.004}});
    }
  }

  add({.name = "revolution_cylinder", .kind = Kind::revolution, .radius = 1.4, .profile = {0.7}});
  add({.name = "revolution_spike", .kind = Kind::revolution, .radius = 1.5, .profile = {0.0, 0.8}});
  add({.name = "revolution_vase", .kind = Kind::revolution, .radius = 2.0,
       .profile = {0.47, 3.90, -9.78, 5.80}});  // [C] ch. 5
  add({.name = "revolution_lantern", .kind = Kind::revolution, .radius = 1.8,
       .profile = {0.3, 1.1, 1.2, -6.3, 1.0, 6.2, -2.9}});

  add({.name = "sag_saddle", .kind = Kind::sag, .rotation = random.rotation(),
       .terms = {{0, 0, 0.1}, {1, 0, -0.2}, {2, 0, 0.4}, {0, 2, -0.3}}});
  add({.name = "sag_cubic", .kind = Kind::sag, .rotation = random.rotation(),
       .terms = {{2, 0, 0.2}, {0, 2, 0.3}, {3, 0, 0.1}, {1, 2, -0.15}, {2, 3, 0.01}, {0, 6, -0.002}}});
  add({.name = "zernike_few", .kind = Kind::zernike, .rotation = random.rotation(), .radius = 1.3,
       .zernike = {{4, 0.2}, {3, -0.05}, {7, 0.03}, {14, 0.01}}});
  add({.name = "zernike_many", .kind = Kind::zernike, .rotation = random.rotation(), .radius = 2.5,
       .zernike = {{2, 0.1}, {6, 0.05}, {12, 0.02}, {16, 0.01}, {18, -0.01}}});
  // A shallow bowl with bumps, of few samples, more along x than along y.
  geometry::HeightGrid bowl{{-1.4, -1.1}, {1.5, 1.2}, 9, 8, {}};
  for (int j = 0; j < bowl.ny; ++j) {
    for (int i = 0; i < bowl.nx; ++i) {
      const double x = i / 4.0 - 1.0, y = j / 3.5 - 1.0;
      bowl.values.push_back(0.3 * x * x + 0.2 * y * y + random.uniform(-0.02, 0.02));
    }
  }
  add({.name = "heights", .kind = Kind::heights, .rotation = random.rotation(), .grid = bowl});
  return zoo;
}

std::vector<ShapeSpec> make_expression_zoo() {
  Random random(20261);
  std::vector<ShapeSpec> zoo;
  const std::pair<const char*, const char*> expressions[] = {
      {"cuboid", "x^4+y^4+z^4-x^2-y^2-z^2"},
      {"torus", "(x^2+y^2+z^2+0.75)^2-4*(x^2+y^2)"},
      {"torus_by_roots", "(sqrt(x^2+y^2)-1)^2+z^2-0.16"},
      {"water", "z-0.1*sin(2*pi*x)"},
      {"sphere", "x^2+y^2+z^2-1"},
      {"bell", "z-exp(-x^2-2*y^2)+0.3"},
  };
  for (const auto& [name, text] : expressions) {
    zoo.push_back({.name = std::string("expression_") + name, .kind = Kind::expression,
                   .radius = 1.6, .expression = text});
    zoo.back().pose = geometry::Pose::make(random.direction(), random.uniform(0.3, 3.0),
                                           random.in_cube(0.7));
  }
  return zoo;
}

}  // namespace

const std::vector<ShapeSpec>& shape_zoo() {
  static const std::vector<ShapeSpec> zoo = make_zoo();
  return zoo;
}

const std::vector<ShapeSpec>& expression_zoo() {
  static const std::vector<ShapeSpec> zoo = make_expression_zoo();
  return zoo;
}

ShapeSpec scaled(const ShapeSpec& spec, double f) {
  ShapeSpec s = spec;
  s.name += "_scaled";
  s.point *= f;
  s.semi_axes *= f;
  s.pose.translation *= f;
  if (s.kind != Kind::cone) s.radius *= f;
  if (s.kind == Kind::torus) s.second *= f;
  s.unit *= f;
  for (std::size_t i = 0; i < s.aspheric.size(); ++i) {
    s.aspheric[i] *= std::pow(f, -3.0 - 2.0 * static_cast<double>(i));
  }
  for (double& c : s.profile) c *= f;
  for (auto& [i, j, c] : s.terms) c *= std::pow(f, 1 - i - j);
  for (auto& [j, c] : s.zernike) c *= f;
  s.grid.min *= f;
  s.grid.max *= f;
  for (double& value : s.grid.values) value *= f;
  for (int i = 6; i < 9; ++i) s.coefficients[i] *= f;
  s.coefficients[9] *= f * f;
  return s;
}

}  // namespace caustic::test
