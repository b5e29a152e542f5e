#include "service/api/shape_json.h"

#include <nlohmann/json.hpp>

#include "geometry/expression/expression_bound.h"
#include "service/api/sag_json.h"

namespace caustic::service {
namespace {

using geometry::kPi;
using geometry::Pose;
using geometry::SurfacePtr;
using geometry::Vec3;

/// What a reader of one shape gets: its members, the length unit in metres, the pose.
struct ShapeContext {
  ObjectReader& shape;
  double metres;
  const Pose& pose;
  std::size_t faults_before;

  Vec3 point(const char* key) const { return pose.point(metres * shape.vector(key)); }
  Vec3 direction(const char* key) const { return pose.direction(shape.direction(key)); }
  double length(const char* key) const { return metres * shape.number(key, kPositive); }
  /// Factories take sound parameters only: call them if nothing was amiss.
  bool sound() const { return shape.faults().count() == faults_before; }
};

SurfacePtr read_plane(const ShapeContext& in) {
  const Vec3 point = in.point("point"), normal = in.direction("normal");
  return in.sound() ? geometry::make_plane(point, normal) : nullptr;
}

SurfacePtr read_sphere(const ShapeContext& in) {
  const Vec3 center = in.point("center");
  const double radius = in.length("radius");
  return in.sound() ? geometry::make_sphere(center, radius) : nullptr;
}

SurfacePtr read_ellipsoid(const ShapeContext& in) {
  const Vec3 center = in.point("center");
  const Vec3 semi_axes = in.metres * in.shape.vector("semi_axes", kPositive);
  return in.sound() ? geometry::make_ellipsoid(center, semi_axes, in.pose.rotation) : nullptr;
}

SurfacePtr read_quadric(const ShapeContext& in) {
  const auto place = in.shape.member("coefficients");
  if (!place) return nullptr;
  const auto given = read_numbers(*place, 10, kAnyNumber, in.shape.faults());
  if (!in.sound()) return nullptr;
  // The same polynomial in metres: X = x/metres in each of its terms.
  std::array<double, 10> c;
  for (std::size_t i = 0; i < 10; ++i)
    c[i] = given[i] / (i < 6 ? in.metres * in.metres : i < 9 ? in.metres : 1.0);
  auto [surface, fault] = geometry::make_quadric(c, in.pose);
  if (!surface) in.shape.faults().add(place->pointer, fault);
  return surface;
}

SurfacePtr read_cylinder(const ShapeContext& in) {
  const Vec3 point = in.point("point"), axis = in.direction("axis");
  const double radius = in.length("radius");
  return in.sound() ? geometry::make_cylinder(point, axis, radius) : nullptr;
}

SurfacePtr read_cone(const ShapeContext& in) {
  const Vec3 apex = in.point("point"), axis = in.direction("axis");
  const double half_angle = in.shape.number("half_angle_degrees", {0.0, 90.0, true, true});
  return in.sound() ? geometry::make_cone(apex, axis, half_angle * kPi / 180.0) : nullptr;
}

SurfacePtr read_torus(const ShapeContext& in) {
  const Vec3 center = in.point("center"), axis = in.direction("axis");
  const double major = in.length("major_radius"), minor = in.length("minor_radius");
  if (in.sound() && minor >= major)
    in.shape.faults().add(in.shape.pointer_to("minor_radius"), "must be less than major_radius");
  return in.sound() ? geometry::make_torus(center, axis, major, minor) : nullptr;
}

SurfacePtr read_conic(const ShapeContext& in) {
  const Vec3 vertex = in.point("vertex"), axis = in.direction("axis");
  const double radius = in.metres * in.shape.number("radius_of_curvature", kAnyNumber);
  const double conic_constant = in.shape.number("conic_constant", kAnyNumber);
  if (in.sound() && std::abs(radius) < kPositive.min)
    in.shape.faults().add(in.shape.pointer_to("radius_of_curvature"), "must not be zero");
  const JsonPlace terms = in.shape.member_or("aspheric", nlohmann::json::array());
  std::vector<double> aspheric;
  double per_length = std::pow(in.metres, -3);  // A_{4+2i} is in unit^-(3+2i)
  for (const JsonPlace& term : read_elements(terms, 20, in.shape.faults())) {
    aspheric.push_back(per_length * read_number(term, kAnyNumber, in.shape.faults()));
    per_length /= in.metres * in.metres;
  }
  if (!in.sound()) return nullptr;
  return geometry::make_conic(vertex, axis, radius, conic_constant, aspheric);
}

SurfacePtr read_revolution(const ShapeContext& in) {
  const Vec3 origin = in.point("origin"), axis = in.direction("axis");
  const double height = in.length("height");
  const auto place = in.shape.member("profile");
  if (!place) return nullptr;
  std::vector<double> profile;
  for (const JsonPlace& c :
       read_elements(*place, geometry::kMaxProfileDegree + 1, in.shape.faults()))
    profile.push_back(in.metres * read_number(c, kAnyNumber, in.shape.faults()));
  if (!in.sound()) return nullptr;
  auto [surface, fault] = geometry::make_revolution(origin, axis, height, profile);
  if (!surface) in.shape.faults().add(place->pointer, fault);
  return surface;
}

SurfacePtr read_height_field(const ShapeContext& in) {
  return read_sag(in.shape, in.metres, in.pose);
}

/// The expression at `key`; its root is −1, with its fault noted, if there is none.
geometry::Expression read_expression(ObjectReader& object, const char* key, double metres) {
  geometry::Expression expression;
  const auto place = object.member(key);
  if (!place) return expression;
  const std::size_t faults_before = object.faults().count();
  const std::string text = read_string(*place, object.faults());
  if (object.faults().count() != faults_before) return expression;
  expression = geometry::read_expression(text, metres);
  if (!expression.fault.empty())
    object.faults().add(place->pointer, expression.fault);
  else if (expression.undefined())
    object.faults().add(place->pointer, "is undefined everywhere");
  else if (expression.constant())
    object.faults().add(place->pointer, "does not depend on x, y or z");
  else
    return expression;
  expression.root = -1;
  return expression;
}

geometry::Box read_bounds(ObjectReader& box, double metres) {
  const std::size_t faults_before = box.faults().count();
  const Vec3 min = metres * box.vector("min"), max = metres * box.vector("max");
  if (box.faults().count() != faults_before) return {min, max};
  for (int i = 0; i < 3; ++i)
    if (min[i] >= max[i])
      box.faults().add(box.pointer_to("max") + '/' + std::to_string(i), "must be greater than min");
  return {min, max};
}

SurfacePtr read_expression_shape(const ShapeContext& in) {
  const geometry::Expression expression = read_expression(in.shape, "expression", in.metres);
  const auto place = in.shape.member("bounds");
  if (!place) return nullptr;
  ObjectReader reader(*place, in.shape.faults());
  const geometry::Box bounds = read_bounds(reader, in.metres);
  if (!in.sound()) return nullptr;
  auto made = geometry::make_expression(expression, bounds, in.pose);
  if (!made.surface)
    in.shape.faults().add(in.shape.pointer_to(made.of_expression ? "expression" : "bounds"),
                          made.fault);
  return made.surface;
}

using ShapeReader = SurfacePtr (*)(const ShapeContext&);

constexpr std::pair<const char*, ShapeReader> kShapes[] = {{"plane", read_plane},
                                                           {"sphere", read_sphere},
                                                           {"ellipsoid", read_ellipsoid},
                                                           {"quadric", read_quadric},
                                                           {"cylinder", read_cylinder},
                                                           {"cone", read_cone},
                                                           {"torus", read_torus},
                                                           {"conic", read_conic},
                                                           {"revolution", read_revolution},
                                                           {"sag", read_height_field},
                                                           {"expression", read_expression_shape}};

std::vector<std::string> shape_names() {
  std::vector<std::string> names;
  for (const auto& [name, reader] : kShapes) names.push_back(name);
  return names;
}

}  // namespace

SurfacePtr read_shape(const JsonPlace& place, double metres, const Pose& pose, Faults& faults) {
  const std::size_t faults_before = faults.count();
  ObjectReader shape(place, faults);
  const std::string type = shape.word("type", shape_names());
  for (const auto& [name, reader] : kShapes) {
    if (type != name) continue;
    if (reader) return reader({shape, metres, pose, faults_before});
    faults.not_supported(shape.pointer_to("type"), type);
  }
  shape.ignore_the_rest();
  return nullptr;
}

void read_aperture(const JsonPlace& place, double metres, std::vector<geometry::Bound>& bounds,
                   Faults& faults) {
  ObjectReader aperture(place, faults);
  const std::string type = aperture.word("type", {"box", "cylinder", "half_space", "expression"});
  if (type == "box") {
    const geometry::Box box = read_bounds(aperture, metres);
    for (geometry::Bound& bound : geometry::box_aperture(box.min, box.max)) bounds.push_back(bound);
  } else if (type == "cylinder") {
    const Vec3 point = metres * aperture.vector("point"), axis = aperture.direction("axis");
    const double radius = metres * aperture.number("radius", kPositive);
    bounds.push_back(geometry::cylinder_aperture(point, axis, radius));
  } else if (type == "half_space") {
    const Vec3 point = metres * aperture.vector("point"), normal = aperture.direction("normal");
    bounds.push_back(geometry::half_space_aperture(point, normal));
  } else if (type == "expression") {
    const geometry::Expression expression = read_expression(aperture, "expression", metres);
    if (expression.root < 0) return;
    bounds.push_back(geometry::expression_aperture(
        std::make_shared<const geometry::ExpressionBound>(expression, metres)));
  } else {
    aperture.ignore_the_rest();
  }
}

}  // namespace caustic::service
