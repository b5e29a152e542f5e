#include "tests/stress/random_shape.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace caustic::stress {
namespace {

using test::Random;

json numbers_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// Exactly the axis half of the time: symmetric scenes are where derivatives vanish together.
Vec3 some_axis(Random& random) {
  return random.index(2) == 0 ? Vec3(Vec3::UnitZ()) : Vec3(random.direction());
}
Point some_place(Random& random) {
  return random.index(2) == 0 ? Point(Point::Zero()) : Point(random.in_cube(0.4));
}

RandomShape plane(Random& random) {
  const Point middle = some_place(random);
  const Vec3 axis = some_axis(random);
  return {.shape = {{"type", "plane"}, {"point", numbers_of(middle)}, {"normal", numbers_of(axis)}},
          .axis = axis,
          .middle = middle,
          .bounded = false};
}

RandomShape sphere(Random& random) {
  const Point center = some_place(random);
  const double radius = random.uniform(0.5, 1.5);
  return {.shape = {{"type", "sphere"}, {"center", numbers_of(center)}, {"radius", radius}},
          .foci = {center, center + Vec3(0, 0, 0.5 * radius)},
          .middle = center,
          .radius = radius};
}

RandomShape ellipsoid(Random& random) {
  const Point center = some_place(random);
  const double b = random.uniform(0.3, 0.9);
  // Of revolution half of the time: with foci.
  const bool round = random.index(2) == 0;
  const Vec3 semi(round ? b : random.uniform(0.3, 1.5), b, random.uniform(1.0, 1.5));
  RandomShape out{.shape = {{"type", "ellipsoid"},
                            {"center", numbers_of(center)},
                            {"semi_axes", numbers_of(semi)}},
                  .middle = center,
                  .radius = semi.maxCoeff()};
  const double c = std::sqrt(std::max(0.0, semi.z() * semi.z() - b * b));
  out.foci = {center + Vec3(0, 0, c), center - Vec3(0, 0, c)};
  return out;
}

RandomShape quadric(Random& random) {
  // λ₁x² + λ₂y² + λ₃z² + 2ℓz + k, all classes that hold a regular surface.
  const double signs[][5] = {
      {1, 1, 1, 0, -1},  {1, 1, -1, 0, -1}, {1, 1, -1, 0, 1},  {1, 1, -1, 0, 0}, {1, 1, 0, -1, 0},
      {1, -1, 0, -1, 0}, {1, 1, 0, 0, -1},  {1, -1, 0, 0, -1}, {1, 0, 0, -1, 0}, {1, 0, 0, 0, -1}};
  const auto& sign = signs[random.index(static_cast<int>(std::size(signs)))];
  const double a = random.uniform(0.5, 2.0);
  const Vec3 lambda(sign[0] * a, sign[1] * (random.index(2) ? a : random.uniform(0.5, 2.0)),
                    sign[2] * random.uniform(0.5, 2.0));
  const double overall =
      random.sign() * (random.index(4) == 0 ? random.log_uniform(1e-3, 1e3) : 1.0);
  const auto c = test::quadric_coefficients(
      overall * lambda, 0.5 * overall * sign[3], overall * sign[4] * random.uniform(0.2, 1.0),
      random.index(2) ? geometry::Mat3(geometry::Mat3::Identity()) : random.rotation(),
      some_place(random));
  json coefficients = json::array();
  for (const double value : c) coefficients.push_back(value);
  return {.shape = {{"type", "quadric"}, {"coefficients", coefficients}},
          .radius = 1.5,
          .bounded = false};
}

RandomShape cylinder(Random& random) {
  const Point middle = some_place(random);
  const Vec3 axis = some_axis(random);
  const double radius = random.uniform(0.3, 1.2);
  return {.shape = {{"type", "cylinder"},
                    {"point", numbers_of(middle)},
                    {"axis", numbers_of(axis)},
                    {"radius", radius}},
          .axis = axis,
          .middle = middle,
          .radius = 1.3 * radius,
          .bounded = false};
}

RandomShape cone(Random& random) {
  const Point apex = some_place(random);
  const Vec3 axis = some_axis(random);
  return {.shape = {{"type", "cone"},
                    {"point", numbers_of(apex)},
                    {"axis", numbers_of(axis)},
                    {"half_angle_degrees", random.uniform(5.0, 85.0)}},
          .foci = {apex},
          .axis = axis,
          .middle = apex,
          .bounded = false};
}

RandomShape torus(Random& random) {
  const Point center = some_place(random);
  const Vec3 axis = some_axis(random);
  const double major = random.uniform(0.5, 1.2);
  // Thin, fat, and nearly closed in the middle.
  const double share =
      random.index(4) == 0 ? 1.0 - random.log_uniform(1e-6, 0.1) : random.log_uniform(0.02, 0.9);
  return {.shape = {{"type", "torus"},
                    {"center", numbers_of(center)},
                    {"axis", numbers_of(axis)},
                    {"major_radius", major},
                    {"minor_radius", share * major}},
          .foci = {center},
          .axis = axis,
          .middle = center,
          .radius = (1.0 + share) * major};
}

RandomShape conic(Random& random) {
  const Point vertex = some_place(random);
  const Vec3 axis = some_axis(random);
  const double R = random.sign() * random.uniform(0.5, 2.0);
  const double ks[] = {-1.0, 0.0, -2.5, -0.4, 0.8, random.uniform(-3.0, 1.5)};
  const double k = ks[random.index(6)];
  RandomShape out{.shape = {{"type", "conic"},
                            {"vertex", numbers_of(vertex)},
                            {"axis", numbers_of(axis)},
                            {"radius_of_curvature", R},
                            {"conic_constant", k}},
                  .axis = axis,
                  .middle = vertex,
                  .bounded = false};
  if (random.index(3) == 0)
    out.shape["aspheric"] = {random.uniform(-0.05, 0.05), random.uniform(-0.02, 0.02)};
  else if (k <= 0.0)
    out.foci.push_back(vertex + axis * (R / (1.0 + std::sqrt(-k))));
  if (1.0 + k > 0.0) out.radius = std::min(1.0, 0.9 * std::abs(R) / std::sqrt(1.0 + k));
  return out;
}

RandomShape revolution(Random& random) {
  const std::vector<std::vector<double>> profiles = {
      {0.7},
      {0.0, 0.8},
      {0.47, 3.90, -9.78, 5.80},
      {0.3, 1.1, 1.2, -6.3, 1.0, 6.2, -2.9},
      {random.uniform(0.2, 0.8), random.uniform(-0.1, 0.6), random.uniform(-0.05, 0.3)}};
  const Point origin = some_place(random);
  const Vec3 axis = some_axis(random);
  const double height = random.uniform(0.8, 2.0);
  return {.shape = {{"type", "revolution"},
                    {"origin", numbers_of(origin)},
                    {"axis", numbers_of(axis)},
                    {"height", height},
                    {"profile", profiles[random.index(5)]}},
          .axis = axis,
          .middle = origin + 0.5 * height * axis,
          .radius = height};
}

json sag_frame(Random& random, const Point& origin) {
  const geometry::Mat3 R =
      random.index(2) ? geometry::Mat3(geometry::Mat3::Identity()) : random.rotation();
  return {{"type", "sag"},
          {"origin", numbers_of(origin)},
          {"x_axis", numbers_of(R.col(0))},
          {"y_axis", numbers_of(R.col(1))}};
}

RandomShape polynomial(Random& random) {
  RandomShape out{.middle = some_place(random), .bounded = false};
  out.shape = sag_frame(random, out.middle);
  out.shape["kind"] = "xy_polynomial";
  const double c = random.uniform(-0.5, 0.5);
  out.shape["terms"] = {
      {{"i", 2}, {"j", 0}, {"c", c}},
      {{"i", 0}, {"j", 2}, {"c", random.index(3) ? random.uniform(-0.5, 0.5) : c}}};
  for (int k = random.index(4); k > 0; --k)
    out.shape["terms"].push_back(
        {{"i", random.index(5)}, {"j", random.index(4)}, {"c", random.uniform(-0.1, 0.1)}});
  return out;
}

RandomShape zernike(Random& random) {
  RandomShape out{.middle = some_place(random), .bounded = false};
  out.shape = sag_frame(random, out.middle);
  out.shape["kind"] = "zernike";
  out.shape["norm_radius"] = random.uniform(1.0, 2.0);
  json coefficients = {{"4", random.uniform(-0.2, 0.2)}};
  for (int k = random.index(4); k > 0; --k)
    coefficients[std::to_string(1 + random.index(20))] = random.uniform(-0.02, 0.02);
  out.shape["coefficients"] = coefficients;
  return out;
}

RandomShape heights(Random& random) {
  RandomShape out{.middle = some_place(random)};
  out.shape = sag_frame(random, out.middle);
  out.shape["kind"] = "heights";
  out.shape["x"] = {-1.0, 1.1}, out.shape["y"] = {-0.9, 1.0};
  const int nx = 6 + random.index(5), ny = 6 + random.index(5);
  const double a = random.uniform(-0.4, 0.4), b = random.uniform(-0.4, 0.4);
  const double rough = random.index(2) ? 0.0 : random.log_uniform(1e-6, 0.02);
  json rows = json::array();
  for (int j = 0; j < ny; ++j) {
    json row = json::array();
    for (int i = 0; i < nx; ++i) {
      const double x = 2.0 * i / (nx - 1) - 1.0, y = 2.0 * j / (ny - 1) - 1.0;
      row.push_back(a * x * x + b * y * y + random.uniform(-rough, rough));
    }
    rows.push_back(row);
  }
  out.shape["values"] = rows;
  return out;
}

RandomShape expression(Random& random) {
  // Some with singular points on them (cones, a swallowtail, crossing planes, a spindle), one with
  // a kink, one with a pole beside it.
  const char* texts[] = {"x^4+y^4+z^4-x^2-y^2-z^2",
                         "(sqrt(x^2+y^2)-1)^2+z^2-0.16",
                         "z-0.1*sin(2*pi*x)",
                         "z-0.1*sin(6*x)-0.06*cos(5*y)",
                         "x^2+y^2+z^2-1",
                         "z-exp(-x^2-2*y^2)+0.3",
                         "x^2+y^2-z^2",
                         "x^2+y^2-z^3",
                         "x^2*z-y^2",
                         "(x^2+y^2+z^2-1)^2-2*((x-1)^2+y^2)",
                         "z*x-y*y*0.3",
                         "z-0.3*abs(x)^3",
                         "z-0.2/(x+2.5)",
                         "z-0.2*log(2.2+x+y)",
                         "z-0.3*sqrt(2+x^2)"};
  const double half = random.uniform(1.1, 1.5);
  const Vec3 shift = random.index(3) ? Vec3(Vec3::Zero()) : Vec3(random.in_cube(0.1));
  return {.shape = {{"type", "expression"},
                    {"expression", texts[random.index(static_cast<int>(std::size(texts)))]},
                    {"bounds",
                     {{"min", numbers_of(shift - half * Vec3::Ones())},
                      {"max", numbers_of(shift + half * Vec3::Ones())}}}},
          .foci = {Point::Zero()},
          .radius = half};
}

using ShapeMaker = RandomShape (*)(Random&);
constexpr ShapeMaker kShapeMakers[] = {
    plane, sphere,     ellipsoid,  quadric, cylinder, cone,       torus,  conic,
    conic, revolution, polynomial, zernike, heights,  expression, sphere, ellipsoid};

}  // namespace

int shape_kinds() { return static_cast<int>(std::size(kShapeMakers)); }
RandomShape random_shape(int kind, Random& random) { return kShapeMakers[kind](random); }
RandomShape random_shape(Random& random) {
  return random_shape(random.index(shape_kinds()), random);
}

}  // namespace caustic::stress
