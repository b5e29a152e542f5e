#include "service/api/scene_json.h"

#include <map>
#include <nlohmann/json.hpp>

#include "service/api/shape_json.h"

namespace caustic::service {
namespace {

using geometry::kPi;
using geometry::Vec2;
using geometry::Vec3;
using nlohmann::json;

/// Indices of refraction; beyond, Snell's law is all rounding.
constexpr Range kIndex{1e-3, 1e3};

Units read_units(ObjectReader& scene) {
  Units units;
  std::vector<std::string> names;
  for (const LengthUnit& unit : kLengthUnits) names.push_back(unit.name);
  const std::string name = scene.word_or("length_unit", names, "m");
  for (const LengthUnit& unit : kLengthUnits)
    if (name == unit.name) units.length = unit;
  units.photometric =
      scene.word_or("quantity", {"radiometric", "photometric"}, "radiometric") == "photometric";
  return units;
}

solver::Light read_point_light(ObjectReader& light, double metres) {
  const Vec3 position = metres * light.vector("position");
  const auto power = light.optional_member("power");
  const auto intensity = light.optional_member("intensity");
  if (power && intensity) light.faults().add(power->pointer, "give intensity or power, not both");
  if (intensity)
    return solver::PointLight{position, read_number(*intensity, kPositive, light.faults())};
  if (power)
    return solver::PointLight{position,
                              read_number(*power, kPositive, light.faults()) / (4.0 * kPi)};
  light.faults().add(light.pointer_to("intensity"), "missing (intensity or power)");
  return solver::PointLight{position, 1.0};
}

solver::Light read_light(const JsonPlace& place, double metres, Faults& faults) {
  ObjectReader light(place, faults);
  const std::string type = light.word("type", {"point", "collimated", "photometric_file"});
  if (type == "point") return read_point_light(light, metres);
  if (type == "collimated") {
    const geometry::Direction direction = light.direction("direction");
    return solver::CollimatedLight{direction, light.number("irradiance", kPositive)};
  }
  light.ignore_the_rest();
  if (!type.empty()) faults.not_supported(light.pointer_to("type"), "photometric_file");
  return solver::PointLight{Vec3::Zero(), 1.0};
}

geometry::Pose read_pose(ObjectReader& surface, double metres) {
  ObjectReader pose(surface.member_or("pose", json::object()), surface.faults());
  double degrees = 0.0;
  geometry::Direction axis = Vec3::UnitZ();
  {
    ObjectReader rotate(pose.member_or("rotate", json::object()), surface.faults());
    rotate.member_or("axis", {0.0, 0.0, 1.0});
    axis = rotate.direction("axis");
    degrees = rotate.number_or("degrees", {-1e6, 1e6}, 0.0);
  }
  pose.member_or("translate", {0.0, 0.0, 0.0});
  return geometry::Pose::make(axis, degrees * kPi / 180.0, metres * pose.vector("translate"));
}

void read_mirror(ObjectReader& optics, solver::Optics& out) {
  const auto n = optics.optional_member("n"), k = optics.optional_member("k");
  if (!n && !k) {
    out.reflectance = optics.number_or("reflectance", {0.0, 1.0, true}, 1.0);
    return;
  }
  if (const auto reflectance = optics.optional_member("reflectance"))
    optics.faults().add(reflectance->pointer, "give reflectance or n and k, not both");
  const double real = optics.number("n", kPositive);
  out.metal = std::complex(real, optics.number("k", {0.0, kPositive.max}));
}

void read_refraction(ObjectReader& optics, solver::Optics& out) {
  out.kind = solver::Optics::Kind::refract;
  out.index_outside = optics.number("index_outside", kIndex);
  out.index_inside = optics.number("index_inside", kIndex);
  out.fresnel = optics.boolean_or("fresnel", false);
}

solver::Optics read_optics(ObjectReader& surface) {
  const auto place = surface.member("optics");
  solver::Optics out;
  if (!place) return out;
  ObjectReader optics(*place, surface.faults());
  const std::string type = optics.word("type", {"mirror", "refract", "absorb"});
  if (type == "mirror") {
    read_mirror(optics, out);
  } else if (type == "refract") {
    read_refraction(optics, out);
  } else {
    out.kind = solver::Optics::Kind::absorb;
    if (type != "absorb") optics.ignore_the_rest();
  }
  return out;
}

/// Names are labels in files and keys in requests: some length, no control characters.
std::string read_name(ObjectReader& surface) {
  const auto place = surface.member("name");
  if (!place) return {};
  const std::string name = read_string(*place, surface.faults());
  const bool printable =
      std::none_of(name.begin(), name.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
  if (place->value->is_string() && (name.empty() || name.size() > 200 || !printable))
    surface.faults().add(place->pointer, "must be 1 to 200 bytes without control characters");
  return name;
}

solver::SystemSurface read_surface(const JsonPlace& place, double metres, Faults& faults) {
  ObjectReader surface(place, faults);
  solver::SystemSurface out;
  out.name = read_name(surface);
  const geometry::Pose pose = read_pose(surface, metres);
  if (const auto shape = surface.member("shape"))
    out.shape = read_shape(*shape, metres, pose, faults);
  out.optics = read_optics(surface);
  const JsonPlace aperture = surface.member_or("aperture", json::array());
  for (const JsonPlace& part : read_elements(aperture, kMaxApertures, faults))
    read_aperture(part, metres, out.bounds, faults);
  return out;
}

std::vector<solver::SystemSurface> read_surfaces(ObjectReader& scene, double metres) {
  std::vector<solver::SystemSurface> out;
  std::map<std::string, std::size_t> seen;
  const auto place = scene.member("surfaces");
  if (!place) return out;
  for (const JsonPlace& element : read_elements(*place, kMaxSurfaces, scene.faults())) {
    out.push_back(read_surface(element, metres, scene.faults()));
    const auto [first, is_new] = seen.emplace(out.back().name, out.size() - 1);
    if (!is_new && !out.back().name.empty())
      scene.faults().add(element.pointer + "/name",
                         "the name of surface " + std::to_string(first->second) + " already");
  }
  if (place->value->is_array() && place->value->empty())
    scene.faults().add(place->pointer, "needs at least one surface");
  return out;
}

geometry::ReceiverFrame read_receiver(const JsonPlace& place, double metres, Faults& faults) {
  ObjectReader receiver(place, faults);
  const std::size_t faults_before = faults.count();
  receiver.word("type", {"plane"});
  const Vec3 origin = metres * receiver.vector("origin");
  const Vec3 u = receiver.direction("u_axis"), v = receiver.direction("v_axis");
  const Vec2 size = metres * receiver.pair("size", kPositive);
  const bool parallel = u.cross(v).norm() < kParallelSine;
  if (parallel && faults.count() == faults_before)
    faults.add(receiver.pointer_to("v_axis"), "must not be parallel to u_axis");
  if (parallel) return geometry::ReceiverFrame::make(origin, Vec3::UnitX(), Vec3::UnitY(), size);
  return geometry::ReceiverFrame::make(origin, u, v, size);
}

}  // namespace

Scene read_scene(const JsonPlace& place, Faults& faults) {
  ObjectReader scene(place, faults);
  Scene out;
  out.units = read_units(scene);
  const double metres = out.units.length.metres;
  if (const auto light = scene.member("light")) out.light = read_light(*light, metres, faults);
  out.surfaces = read_surfaces(scene, metres);
  if (const auto receiver = scene.member("receiver"))
    out.receiver = read_receiver(*receiver, metres, faults);
  return out;
}

}  // namespace caustic::service
