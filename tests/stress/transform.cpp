#include "tests/stress/transform.h"

#include <cctype>
#include <cmath>
#include <cstdio>

namespace caustic::stress {
namespace {

json array_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

std::string digits(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.17g", value);
  return buffer;
}

/// The expression with other expressions for x, y, z.
std::string substituted(const std::string& text, const std::array<std::string, 3>& by) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i;
    while (end < text.size() && std::isalpha(static_cast<unsigned char>(text[end]))) ++end;
    const std::string word = text.substr(i, end - i);
    // The exponent of a number is no word.
    const bool after_digit =
        i > 0 && (std::isdigit(static_cast<unsigned char>(text[i - 1])) || text[i - 1] == '.');
    if (word.size() == 1 && word[0] >= 'x' && word[0] <= 'z' && !after_digit)
      out += '(' + by[word[0] - 'x'] + ')';
    else
      out += end > i ? word : std::string(1, text[end++]);
    i = end;
  }
  return out;
}

/// Boxes stand in the world's axes: as half-spaces they can be turned.
json without_boxes(const json& apertures) {
  json out = json::array();
  for (const json& a : apertures) {
    if (a["type"] != "box") {
      out.push_back(a);
      continue;
    }
    for (int i = 0; i < 3; ++i) {
      Vec3 axis = Vec3::Unit(i);
      out.push_back({{"type", "half_space"}, {"point", a["max"]}, {"normal", array_of(axis)}});
      out.push_back({{"type", "half_space"}, {"point", a["min"]}, {"normal", array_of(-axis)}});
    }
  }
  return out;
}

void set_pose(json& surface, const geometry::Mat3& rotation, const Vec3& translation) {
  const Eigen::AngleAxisd turn(rotation);
  surface["pose"] = {
      {"rotate",
       {{"axis", array_of(turn.axis())}, {"degrees", turn.angle() * 180.0 / geometry::kPi}}},
      {"translate", array_of(translation)}};
}

/// Places and directions of light, receiver and apertures by one affine map; A is orthogonal.
void map_world(json& scene, const geometry::Mat3& A, const Vec3& t) {
  const auto place = [&](json& at) { at = array_of(A * vec3(at) + t); };
  const auto direction = [&](json& at) { at = array_of(A * vec3(at)); };
  json& light = scene["light"];
  if (light.contains("position")) place(light["position"]);
  if (light.contains("direction")) direction(light["direction"]);
  json& receiver = scene["receiver"];
  place(receiver["origin"]), direction(receiver["u_axis"]), direction(receiver["v_axis"]);
  for (json& surface : scene["surfaces"]) {
    if (!surface.contains("aperture")) continue;
    surface["aperture"] = without_boxes(surface["aperture"]);
    for (json& a : surface["aperture"]) {
      if (a.contains("point")) place(a["point"]);
      if (a.contains("axis")) direction(a["axis"]);
      if (a.contains("normal")) direction(a["normal"]);
      if (!a.contains("expression")) continue;
      // f'(x) = f(Aᵀ(x − t)).
      const Vec3 back = -(A.transpose() * t);
      std::array<std::string, 3> by;
      for (int i = 0; i < 3; ++i)
        by[i] = digits(A(0, i)) + "*x+(" + digits(A(1, i)) + ")*y+(" + digits(A(2, i)) + ")*z+(" +
                digits(back[i]) + ")";
      a["expression"] = substituted(a["expression"], by);
    }
  }
}

void flip(json& vector) { vector[0] = -vector[0].get<double>(); }

void negate(json& vector) {
  for (json& number : vector) number = -number.get<double>();
}

void mirror_sag(json& shape) {
  // With the x axis turned about, x ↦ −x and the height stays what it was.
  flip(shape["origin"]), flip(shape["x_axis"]), flip(shape["y_axis"]);
  negate(shape["x_axis"]);
  const std::string kind = shape["kind"];
  if (kind == "xy_polynomial") {
    for (json& term : shape["terms"])
      if (term["i"].get<int>() % 2) term["c"] = -term["c"].get<double>();
  } else if (kind == "zernike") {
    // θ ↦ π − θ: cos mθ gains (−1)^m, sin mθ gains (−1)^(m+1).
    for (auto& [key, c] : shape["coefficients"].items()) {
      const int j = std::stoi(key);
      int n = 0;
      while ((n + 1) * (n + 2) / 2 <= j) ++n;
      const int m = 2 * j - n * (n + 2);
      if ((m >= 0) == (std::abs(m) % 2 == 1)) c = -c.get<double>();
    }
  } else {
    shape["x"] = {-shape["x"][1].get<double>(), -shape["x"][0].get<double>()};
    for (json& row : shape["values"]) std::reverse(row.begin(), row.end());
  }
}

void mirror_shape(json& shape) {
  const std::string type = shape["type"];
  if (type == "sag") return mirror_sag(shape);
  if (type == "quadric") {
    for (const int i : {3, 4, 6})
      shape["coefficients"][i] = -shape["coefficients"][i].get<double>();
    return;
  }
  if (type == "expression") {
    shape["expression"] = substituted(shape["expression"], {"-x", "y", "z"});
    const json lo = shape["bounds"]["min"][0], hi = shape["bounds"]["max"][0];
    shape["bounds"]["min"][0] = -hi.get<double>();
    shape["bounds"]["max"][0] = -lo.get<double>();
    return;
  }
  for (const char* key : {"point", "normal", "center", "axis", "vertex", "origin"})
    if (shape.contains(key)) flip(shape[key]);
}

void times(json& at, double factor) {
  if (at.is_array()) {
    for (json& part : at) times(part, factor);
  } else {
    at = factor * at.get<double>();
  }
}

void scale_members(json& object, double factor, std::initializer_list<const char*> keys) {
  for (const char* key : keys)
    if (object.contains(key)) times(object[key], factor);
}

void scale_shape(json& shape, double k) {
  const std::string type = shape["type"];
  scale_members(
      shape, k,
      {"point", "center", "radius", "semi_axes", "vertex", "origin", "height", "major_radius",
       "minor_radius", "radius_of_curvature", "profile", "norm_radius", "x", "y", "values"});
  if (type == "quadric") {
    for (const int i : {6, 7, 8}) times(shape["coefficients"][i], k);
    times(shape["coefficients"][9], k * k);
  } else if (type == "conic" && shape.contains("aspheric")) {
    double factor = std::pow(k, -3);
    for (json& a : shape["aspheric"]) {
      times(a, factor);
      factor /= k * k;
    }
  } else if (type == "sag" && shape.contains("terms")) {
    for (json& t : shape["terms"])
      times(t["c"], std::pow(k, 1 - t["i"].get<int>() - t["j"].get<int>()));
  } else if (type == "sag" && shape.contains("coefficients")) {
    for (auto& [index, c] : shape["coefficients"].items()) times(c, k);
  } else if (type == "expression") {
    const std::string by = digits(1.0 / k) + "*";
    shape["expression"] = substituted(shape["expression"], {by + "x", by + "y", by + "z"});
    times(shape["bounds"]["min"], k), times(shape["bounds"]["max"], k);
  }
}

}  // namespace

json moved(json request, const geometry::Mat3& rotation, const Vec3& translation) {
  json& scene = request["scene"];
  map_world(scene, rotation, translation);
  for (json& surface : scene["surfaces"]) {
    const geometry::Pose pose = read_pose(surface, 1.0);
    set_pose(surface, rotation * pose.rotation, rotation * pose.translation + translation);
  }
  return request;
}

json mirrored(json request) {
  const geometry::Mat3 M = Vec3(-1, 1, 1).asDiagonal();
  json& scene = request["scene"];
  map_world(scene, M, Vec3::Zero());
  for (json& surface : scene["surfaces"]) {
    mirror_shape(surface["shape"]);
    const geometry::Pose pose = read_pose(surface, 1.0);
    set_pose(surface, M * pose.rotation * M, M * pose.translation);
  }
  return request;
}

json scaled(json request, double k) {
  json& scene = request["scene"];
  scale_members(scene["light"], k, {"position"});
  scale_members(scene["light"], k * k, {"intensity", "power"});
  scale_members(scene["receiver"], k, {"origin", "size"});
  for (json& surface : scene["surfaces"]) {
    scale_shape(surface["shape"], k);
    if (surface.contains("pose")) scale_members(surface["pose"], k, {"translate"});
    if (!surface.contains("aperture")) continue;
    for (json& a : surface["aperture"]) {
      scale_members(a, k, {"min", "max", "point", "radius"});
      const std::string by = digits(1.0 / k) + "*";
      if (a.contains("expression"))
        a["expression"] = substituted(a["expression"], {by + "x", by + "y", by + "z"});
    }
  }
  if (request.contains("tolerance")) scale_members(request["tolerance"], k, {"chord"});
  return request;
}

json permuted(json request) {
  json& surfaces = request["scene"]["surfaces"];
  std::reverse(surfaces.begin(), surfaces.end());
  return request;
}

}  // namespace caustic::stress
