#include "tests/stress/oracle_scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "tests/support/reference_real.h"

namespace caustic::stress {

using Kind = test::ShapeSpec::Kind;
using solver::Optics;

Vec3 vec3(const json& a) { return {a[0].get<double>(), a[1].get<double>(), a[2].get<double>()}; }

namespace {

double unit_of(const json& scene) {
  const std::map<std::string, double> metres{
      {"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}};
  return metres.at(scene.value("length_unit", "m"));
}

std::vector<double> numbers(const json& array, double factor = 1.0) {
  std::vector<double> out;
  for (const json& number : array) out.push_back(factor * number.get<double>());
  return out;
}

void read_sag_shape(const json& j, double metres, test::ShapeSpec& s) {
  s.point = metres * vec3(j["origin"]);
  const Vec3 x = vec3(j["x_axis"]).normalized(), z = x.cross(vec3(j["y_axis"])).normalized();
  s.rotation.col(0) = x;
  s.rotation.col(1) = z.cross(x);
  s.rotation.col(2) = z;
  const std::string kind = j["kind"];
  if (kind == "xy_polynomial") {
    s.kind = Kind::sag;
    for (const json& t : j["terms"]) {
      const int a = t["i"], b = t["j"];
      s.terms.push_back({a, b, t["c"].get<double>() * std::pow(metres, 1 - a - b)});
    }
  } else if (kind == "zernike") {
    s.kind = Kind::zernike;
    s.radius = metres * j["norm_radius"].get<double>();
    for (const auto& [index, c] : j["coefficients"].items())
      s.zernike.push_back({std::stoi(index), metres * c.get<double>()});
  } else {
    s.kind = Kind::heights;
    const auto x_range = numbers(j["x"], metres), y_range = numbers(j["y"], metres);
    s.grid = {{x_range[0], y_range[0]}, {x_range[1], y_range[1]}, 0, 0, {}};
    s.grid.ny = static_cast<int>(j["values"].size());
    s.grid.nx = static_cast<int>(j["values"][0].size());
    for (const json& row : j["values"])
      for (const double h : numbers(row, metres)) s.grid.values.push_back(h);
  }
}

test::ShapeSpec read_shape_of(const json& j, double metres) {
  test::ShapeSpec s;
  const std::string type = s.name = j["type"];
  const auto length = [&](const char* key) { return metres * j[key].get<double>(); };
  const auto place = [&](const char* key) { s.point = metres * vec3(j[key]); };
  const auto along = [&](const char* key) { s.axis = vec3(j[key]).normalized(); };
  if (type == "plane") {
    s.kind = Kind::plane;
    place("point"), along("normal");
  } else if (type == "sphere") {
    s.kind = Kind::sphere;
    place("center"), s.radius = length("radius");
  } else if (type == "ellipsoid") {
    s.kind = Kind::ellipsoid;
    place("center"), s.semi_axes = metres * vec3(j["semi_axes"]);
  } else if (type == "quadric") {
    s.kind = Kind::quadric;
    for (std::size_t i = 0; i < 10; ++i)
      s.coefficients[i] = j["coefficients"][i].get<double>() * (i < 6   ? 1.0
                                                                : i < 9 ? metres
                                                                        : metres * metres);
  } else if (type == "cylinder") {
    s.kind = Kind::cylinder;
    place("point"), along("axis"), s.radius = length("radius");
  } else if (type == "cone") {
    s.kind = Kind::cone;
    place("point"), along("axis");
    s.radius = j["half_angle_degrees"].get<double>() * geometry::kPi / 180.0;
  } else if (type == "torus") {
    s.kind = Kind::torus;
    place("center"), along("axis");
    s.radius = length("major_radius"), s.second = length("minor_radius");
  } else if (type == "conic") {
    s.kind = Kind::conic;
    place("vertex"), along("axis");
    s.radius = length("radius_of_curvature"), s.second = j["conic_constant"];
    double factor = std::pow(metres, -3);
    for (const double a : numbers(j.value("aspheric", json::array()))) {
      s.aspheric.push_back(factor * a);
      factor /= metres * metres;
    }
  } else if (type == "revolution") {
    s.kind = Kind::revolution;
    place("origin"), along("axis");
    s.radius = length("height"), s.profile = numbers(j["profile"], metres);
  } else if (type == "sag") {
    read_sag_shape(j, metres, s);
  } else if (type == "expression") {
    s.kind = Kind::expression;
    s.expression = j["expression"], s.unit = metres;
  } else {
    throw std::runtime_error("no oracle for " + type);
  }
  return s;
}

OracleAperture read_aperture_of(const json& j, double metres) {
  const std::string type = j["type"];
  OracleAperture out{.kind = OracleAperture::Kind::box, .metres = metres};
  if (type == "box") {
    out.a = metres * vec3(j["min"]), out.b = metres * vec3(j["max"]);
  } else if (type == "cylinder") {
    out.kind = OracleAperture::Kind::cylinder;
    out.a = metres * vec3(j["point"]), out.b = vec3(j["axis"]).normalized();
    out.radius = metres * j["radius"].get<double>();
  } else if (type == "half_space") {
    out.kind = OracleAperture::Kind::half_space;
    out.a = metres * vec3(j["point"]), out.b = vec3(j["normal"]).normalized();
  } else {
    out.kind = OracleAperture::Kind::expression;
    out.expression = std::make_shared<LongExpression>(j["expression"].get<std::string>());
  }
  return out;
}

Optics read_optics_of(const json& j) {
  Optics out;
  const std::string type = j["type"];
  if (type == "mirror") {
    out.reflectance = j.value("reflectance", 1.0);
    if (j.contains("n")) out.metal = std::complex(j["n"].get<double>(), j["k"].get<double>());
  } else if (type == "refract") {
    out.kind = Optics::Kind::refract;
    out.index_outside = j["index_outside"], out.index_inside = j["index_inside"];
    out.fresnel = j.value("fresnel", false);
  } else {
    out.kind = Optics::Kind::absorb;
  }
  return out;
}

solver::Light read_light_of(const json& j, double metres) {
  if (j["type"] == "collimated")
    return solver::CollimatedLight{vec3(j["direction"]).normalized(), j["irradiance"]};
  const double intensity = j.contains("power") ? j["power"].get<double>() / (4.0 * geometry::kPi)
                                               : j["intensity"].get<double>();
  return solver::PointLight{metres * vec3(j["position"]), intensity};
}

LongVec wide(const Vec3& v) { return v.cast<Long>(); }

}  // namespace

geometry::Pose read_pose(const json& surface, double metres) {
  const json pose = surface.value("pose", json::object());
  const json rotate = pose.value("rotate", json::object());
  const Vec3 axis = vec3(rotate.value("axis", json{0.0, 0.0, 1.0})).normalized();
  const double degrees = rotate.value("degrees", 0.0);
  const Vec3 translate = vec3(pose.value("translate", json{0.0, 0.0, 0.0}));
  return geometry::Pose::make(axis, degrees * geometry::kPi / 180.0, metres * translate);
}

OracleSurface read_oracle_surface(const json& j, double metres) {
  OracleSurface out;
  out.name = j["name"];
  out.shape = read_shape_of(j["shape"], metres);
  out.shape.pose = read_pose(j, metres);
  if (out.shape.kind == Kind::expression) {
    out.expression = std::make_shared<LongExpression>(out.shape.expression);
    out.lo = metres * vec3(j["shape"]["bounds"]["min"]);
    out.hi = metres * vec3(j["shape"]["bounds"]["max"]);
  }
  for (const json& aperture : j.value("aperture", json::array()))
    out.apertures.push_back(read_aperture_of(aperture, metres));
  out.optics = read_optics_of(j["optics"]);
  return out;
}

OracleScene read_oracle_scene(const json& scene) {
  OracleScene out;
  out.metres = unit_of(scene);
  out.light = read_light_of(scene["light"], out.metres);
  for (const json& surface : scene["surfaces"])
    out.surfaces.push_back(read_oracle_surface(surface, out.metres));
  const json& r = scene["receiver"];
  const Vec2 size(r["size"][0].get<double>(), r["size"][1].get<double>());
  out.receiver = geometry::ReceiverFrame::make(out.metres * vec3(r["origin"]), vec3(r["u_axis"]),
                                               vec3(r["v_axis"]), out.metres * size);
  const Point o = out.receiver.origin;
  out.size = 2.0 * out.receiver.half.norm();
  if (out.point_light())
    out.size = std::max(out.size, (std::get<solver::PointLight>(out.light).position - o).norm());
  for (const OracleSurface& s : out.surfaces) {
    // Of what is unbounded the places that describe it are no farther than what is lit of it.
    const auto [center, radius] = s.ball();
    out.size = std::max(out.size, (center - o).norm() + (std::isfinite(radius) ? radius : 0.0));
    for (const OracleAperture& a : s.apertures)
      if (a.kind != OracleAperture::Kind::expression)
        out.size = std::max(out.size, (a.a - o).norm());
  }
  return out;
}

int OracleScene::index_of(const std::string& name) const {
  for (std::size_t i = 0; i < surfaces.size(); ++i)
    if (surfaces[i].name == name) return static_cast<int>(i);
  throw std::runtime_error("no surface " + name);
}

Long OracleAperture::excess(const LongVec& x) const {
  switch (kind) {
    case Kind::box:
      return std::max((wide(a) - x).maxCoeff(), (x - wide(b)).maxCoeff());
    case Kind::half_space:
      return wide(b).dot(x - wide(a));
    case Kind::cylinder: {
      const LongVec y = x - wide(a), axis = wide(b).normalized();
      return (y - axis * axis.dot(y)).norm() - Long(radius);
    }
    case Kind::expression:
      break;
  }
  const Long m = metres;
  const Long f = (*expression)({x[0] / m, x[1] / m, x[2] / m});
  return std::isnan(f) ? Long(INFINITY) : f;
}

LongVec OracleSurface::local(const LongVec& x) const {
  return shape.pose.rotation.cast<Long>().transpose() * (x - wide(shape.pose.translation));
}

Long OracleSurface::value(const LongVec& x) const {
  if (!expression)
    return test::reference_implicit(shape, std::array<Long, 3>{x[0], x[1], x[2]}).value;
  const LongVec y = local(x) / Long(shape.unit);
  return (*expression)({y[0], y[1], y[2]});
}

LongVec OracleSurface::gradient(const LongVec& x) const {
  if (!expression) {
    const auto g = test::reference_implicit(shape, std::array<Long, 3>{x[0], x[1], x[2]}).gradient;
    return {g[0], g[1], g[2]};
  }
  const Long step = 1e-6L * (hi - lo).minCoeff() / shape.unit;
  const LongVec y = local(x) / Long(shape.unit);
  LongVec g;
  for (int i = 0; i < 3; ++i) g[i] = expression->partial({y[0], y[1], y[2]}, i, step);
  return shape.pose.rotation.cast<Long>() * g / Long(shape.unit);
}

Long OracleSurface::own_excess(const LongVec& y) const {
  if (shape.kind == Kind::expression)
    return std::max((wide(lo) - y).maxCoeff(), (y - wide(hi)).maxCoeff());
  const LongVec z = y - wide(shape.point);
  if (shape.kind == Kind::heights) {
    const Long u = z.dot(wide(shape.rotation.col(0))), v = z.dot(wide(shape.rotation.col(1)));
    const auto& g = shape.grid;
    return std::max(
        {Long(g.min.x()) - u, u - Long(g.max.x()), Long(g.min.y()) - v, v - Long(g.max.y())});
  }
  const LongVec axis = wide(shape.axis).normalized();
  const Long height = axis.dot(z), rho = (z - height * axis).norm();
  if (shape.kind == Kind::revolution) return std::max(-height, height - Long(shape.radius));
  const Long e = 1.0L + shape.second, R = std::abs(shape.radius);
  if (shape.kind != Kind::conic || e <= 0.0L) return -INFINITY;
  // The half of the ellipsoid on the side of the vertex, up to the last radius.
  const Long beyond = e * (shape.radius > 0.0 ? height : -height) - R;
  const Long past_rim = rho - R / std::sqrt(e);
  return shape.aspheric.empty() ? std::max(beyond, past_rim) : past_rim;
}

Long OracleSurface::excess(const LongVec& x) const {
  Long worst = own_excess(local(x));
  for (const OracleAperture& a : apertures) worst = std::max(worst, a.excess(x));
  return worst;
}

std::pair<Point, double> OracleSurface::ball() const {
  for (const OracleAperture& a : apertures) {
    if (a.kind == OracleAperture::Kind::box) return {0.5 * (a.a + a.b), 0.5 * (a.b - a.a).norm()};
  }
  const Point middle = shape.pose.point(shape.point);
  switch (shape.kind) {
    case Kind::sphere:
      return {middle, shape.radius};
    case Kind::ellipsoid:
      return {middle, shape.semi_axes.maxCoeff()};
    case Kind::torus:
      return {middle, shape.radius + shape.second};
    case Kind::heights: {
      const auto& g = shape.grid;
      const auto [low, high] = std::minmax_element(g.values.begin(), g.values.end());
      return {middle, std::hypot(g.min.norm() + g.max.norm(), *high - *low)};
    }
    case Kind::expression:
      return {shape.pose.point(0.5 * (lo + hi)), 0.5 * (hi - lo).norm()};
    case Kind::revolution: {
      double widest = 0.0;
      for (const double c : shape.profile) widest += std::abs(c);
      return {middle, std::hypot(widest, shape.radius)};
    }
    default:
      return {middle, geometry::kInfinity};
  }
}

}  // namespace caustic::stress
