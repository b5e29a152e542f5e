#include "tests/stress/random_scene.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "service/api/problem.h"
#include "tests/stress/oracle.h"
#include "tests/stress/random_shape.h"
#include "tests/stress/transform.h"
#include "tests/stress/trial.h"

namespace caustic::stress {
namespace {

using test::Random;

json as_array(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// How the light stands to the first surface.
enum class Placing { plain, beam, near_surface, focus, axis, grazing };
/// How the receiver stands to the last ray.
enum class Screen { plain, through_focus, across, grazing, touching };

/// What of a scene is chosen before anything is placed.
struct Ingredients {
  int hops = 1;
  Placing placing = Placing::plain;
  Screen screen = Screen::plain;
  bool aligned = false;  ///< no pose: axes of symmetry stay the world's
  bool total = false, certify = false, direct = false;
  bool nearly_total_reflection = false;
  int blockers = 0;
  bool twin = false;  ///< the first surface again, hardly displaced
  double scale = 1.0;
};

Ingredients choose(Random& random) {
  Ingredients in;
  const int hops = random.index(10);
  in.hops = hops < 6 ? 1 : hops < 9 ? 2 : 3;
  const Placing placings[] = {Placing::plain, Placing::plain,  Placing::beam,
                              Placing::beam,  Placing::axis,   Placing::near_surface,
                              Placing::focus, Placing::grazing};
  in.placing = placings[random.index(8)];
  const Screen screens[] = {Screen::plain,  Screen::plain,   Screen::plain,   Screen::through_focus,
                            Screen::across, Screen::grazing, Screen::touching};
  in.screen = screens[random.index(7)];
  in.aligned = random.index(4) == 0;
  in.total = random.index(2) == 0;
  in.certify = random.index(16) == 0;
  in.direct = in.total && random.index(5) == 0;
  in.nearly_total_reflection = random.index(6) == 0;
  in.blockers = random.index(4) == 0 ? 1 + random.index(2) : 0;
  in.twin = random.index(16) == 0;
  if (random.index(4) == 0) in.scale = std::pow(10.0, random.uniform(-6.0, 6.0));
  return in;
}

class Maker {
 public:
  explicit Maker(Random& random) : random_(random), in_(choose(random)) {}

  json make();

 private:
  struct Ray {
    Point o;
    Vec3 w;
  };

  bool place_first();
  void place_light();
  bool pass(const json& surface);
  bool place_next(int hop);
  json pose_about(const Point& local, const Point& world);
  json aperture_about(const Point& place, double radius, bool needed);
  json optics(double cosine);
  void place_receiver();
  void add_blockers();
  std::optional<Point> place_on(const json& surface, const RandomShape& of);
  json levels();

  Random& random_;
  Ingredients in_;
  json surfaces_ = json::array(), light_, receiver_;
  const char* unit_ = "m";
  RandomShape first_;
  geometry::Pose first_pose_;
  Point x_;  // on the first surface
  Vec3 normal_;
  Ray ray_;  // after what has been placed
  std::vector<std::string> names_;
  std::vector<Point> way_;  // hits of the path
};

std::vector<Long> roots_of(const json& surface, const Point& o, const Vec3& w, double t0,
                           double t1) {
  return surface_roots(read_oracle_surface(surface, 1.0),
                       {o.cast<Long>(), w.cast<Long>().normalized(), t0, t1}, 3.0);
}

std::optional<Point> Maker::place_on(const json& surface, const RandomShape& of) {
  const geometry::Pose pose = read_pose(surface, 1.0);
  const Point middle = pose.point(of.middle);
  for (int i = 0; i < 12; ++i) {
    const Vec3 way = random_.direction();
    const Point through = middle + random_.in_cube(0.6 * of.radius);
    const auto found = roots_of(surface, through - 4.0 * way, way, 0.0, 8.0);
    if (found.empty()) continue;
    const auto t = static_cast<double>(found[random_.index(static_cast<int>(found.size()))]);
    const Point x = through - 4.0 * way + t * way;
    if ((x - middle).norm() < 2.0 * of.radius) return x;
  }
  return std::nullopt;
}

json Maker::aperture_about(const Point& place, double radius, bool needed) {
  const auto half_space = [&](const Point& point, const Vec3& normal) -> json {
    return {{"type", "half_space"}, {"point", as_array(point)}, {"normal", as_array(normal)}};
  };
  const double size = radius * random_.log_uniform(0.1, 1.5);
  json out = json::array();
  switch (random_.index(7)) {
    case 0:
      if (!needed) return out;
      [[fallthrough]];
    case 1: {
      const Vec3 half(size * random_.uniform(0.5, 2.0), size, size * random_.uniform(0.5, 2.0));
      const Point middle = place + random_.in_cube(0.4 * size);
      out.push_back(
          {{"type", "box"}, {"min", as_array(middle - half)}, {"max", as_array(middle + half)}});
      return out;
    }
    case 2:
      out.push_back({{"type", "cylinder"},
                     {"point", as_array(place + random_.in_cube(0.4 * size))},
                     {"axis", as_array(random_.direction())},
                     {"radius", size}});
      break;
    case 3: {  // a sliver
      const Vec3 across = random_.direction();
      const double gap = radius * std::pow(10.0, random_.uniform(-6.0, -1.0));
      out.push_back(half_space(place + 0.4 * gap * across, across));
      out.push_back(half_space(place - 0.6 * gap * across, -across));
      break;
    }
    case 4: {
      const Point c = place + random_.in_cube(0.3 * size);
      const auto power = [](const char* axis, double at) {
        return std::string("(") + axis + "-(" + std::to_string(at) + "))^2";
      };
      out.push_back({{"type", "expression"},
                     {"expression", power("x", c.x()) + "+" + power("y", c.y()) + "+1.5*" +
                                        power("z", c.z()) + "-" + std::to_string(size * size)}});
      return out;
    }
    case 5:
      out.push_back(half_space(place + random_.in_cube(0.3 * radius), random_.direction()));
      break;
    default:
      break;
  }
  if (needed) {
    const Vec3 half = radius * Vec3::Ones();
    out.push_back(
        {{"type", "box"}, {"min", as_array(place - half)}, {"max", as_array(place + half)}});
  }
  return out;
}

json Maker::optics(double cosine) {
  if (random_.index(5) < 3 && !in_.nearly_total_reflection) {
    if (random_.index(4)) return {{"type", "mirror"}, {"reflectance", random_.uniform(0.3, 1.0)}};
    return {
        {"type", "mirror"}, {"n", random_.uniform(0.05, 2.0)}, {"k", random_.uniform(0.0, 5.0)}};
  }
  double outside = 1.0, inside = random_.index(2) ? 1.5 : random_.uniform(1.01, 2.5);
  if (in_.nearly_total_reflection) {
    // Light from one side just fails to be reflected as a whole.
    const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    inside = std::clamp(sine * (1.0 + std::pow(10.0, random_.uniform(-9.0, -1.0))), 0.05, 0.999);
  }
  if (random_.index(2)) std::swap(outside, inside);
  return {{"type", "refract"},
          {"index_outside", outside},
          {"index_inside", inside},
          {"fresnel", random_.index(2) == 0}};
}

/// The ray goes on behind the surface, which gets its optics now; false if it cannot.
bool Maker::pass(const json& placed) {
  json surface = placed;
  const OracleSurface oracle = read_oracle_surface(surface, 1.0);
  LongVec g = oracle.gradient(x_.cast<Long>());
  if (!(g.norm() > 0.0L)) return false;
  g.normalize();
  LongVec w = ray_.w.cast<Long>();
  surface["optics"] = optics(std::abs(static_cast<double>(g.dot(w))));
  Long share = 1.0L;
  LongVec out = w;
  if (!PathMap<Long>::bend(read_oracle_surface(surface, 1.0).optics, g, out, share)) {
    std::swap(surface["optics"]["index_outside"], surface["optics"]["index_inside"]);
    out = w;
    if (!PathMap<Long>::bend(read_oracle_surface(surface, 1.0).optics, g, out, share)) return false;
  }
  surface["name"] = "s" + std::to_string(surfaces_.size());
  names_.push_back(surface["name"]);
  surfaces_.push_back(surface);
  way_.push_back(x_);
  ray_ = {x_, out.cast<double>()};
  return true;
}

json pose_json(const geometry::Pose& pose) {
  const Eigen::AngleAxisd turn(pose.rotation);
  return {{"rotate",
           {{"axis", as_array(turn.axis())}, {"degrees", turn.angle() * 180.0 / geometry::kPi}}},
          {"translate", as_array(pose.translation)}};
}

bool Maker::place_first() {
  first_ = random_shape(random_);
  json surface = {{"name", "s0"}, {"shape", first_.shape}, {"optics", {{"type", "mirror"}}}};
  if (!in_.aligned) {
    const geometry::Pose pose{
        random_.index(3) ? random_.rotation() : geometry::Mat3(geometry::Mat3::Identity()),
        random_.in_cube(1.0)};
    surface["pose"] = pose_json(pose);
  }
  first_pose_ = read_pose(surface, 1.0);
  const auto place = place_on(surface, first_);
  if (!place) return false;
  x_ = *place;
  normal_ = read_oracle_surface(surface, 1.0).gradient(x_.cast<Long>()).cast<double>().normalized();
  place_light();
  // The light may meet another part of the surface first, or none.
  if (light_["type"] == "point")
    ray_.o = vec3(light_["position"]);
  else
    ray_.o = x_ - 10.0 * ray_.w;
  const auto found = roots_of(surface, ray_.o, ray_.w, 1e-12, 30.0);
  if (found.empty()) return false;
  x_ = ray_.o + static_cast<double>(found.front()) * ray_.w;
  surface["aperture"] = aperture_about(x_, first_.radius, !first_.bounded && random_.index(6) > 0);
  return pass(surface);
}

void Maker::place_light() {
  const double intensity = random_.log_uniform(0.01, 1000.0);
  const Vec3 up = random_.sign() * normal_;
  const auto point = [&](const Point& position) {
    light_ = {{"type", "point"}, {"position", as_array(position)}, {"intensity", intensity}};
    ray_.w = (x_ - position).normalized();
  };
  const auto beam = [&](const Vec3& direction) {
    light_ = {
        {"type", "collimated"}, {"direction", as_array(direction)}, {"irradiance", intensity}};
    ray_.w = direction.normalized();
  };
  const Vec3 axis = first_pose_.direction(first_.axis);
  const Vec3 along = (random_.direction() + 1e-3 * normal_).cross(normal_).normalized();
  switch (in_.placing) {
    case Placing::plain:
      return point(x_ +
                   random_.log_uniform(0.3, 5.0) * (up + 1.2 * random_.in_cube(1.0)).normalized());
    case Placing::beam:
      return beam(-(up + 0.8 * random_.in_cube(1.0)).normalized());
    case Placing::near_surface:
      return point(x_ +
                   std::pow(10.0, random_.uniform(-8.0, -1.0)) * (up + 0.5 * random_.in_cube(1.0)));
    case Placing::focus: {
      const auto& foci = first_.foci;
      if (foci.empty()) return beam(random_.sign() * axis);
      const double off = random_.index(3) ? std::pow(10.0, random_.uniform(-10.0, -1.0)) : 0.0;
      return point(first_pose_.point(foci[random_.index(static_cast<int>(foci.size()))]) +
                   off * random_.direction());
    }
    case Placing::axis:
      if (random_.index(2)) return beam(random_.sign() * axis);
      return point(first_pose_.point(first_.middle) + random_.uniform(-4.0, 4.0) * axis);
    case Placing::grazing: {
      const double angle = std::pow(10.0, random_.uniform(-6.0, -1.0));
      if (random_.index(2)) return beam(along - angle * up);
      return point(x_ - random_.log_uniform(0.5, 4.0) * (along - angle * up));
    }
  }
}

bool Maker::place_next(int hop) {
  // The same surface again is met by itself often enough; the others are put into the way.
  const double ahead = random_.index(6) ? random_.log_uniform(0.3, 2.0)
                                        : std::pow(10.0, random_.uniform(-8.0, -1.0));
  const RandomShape next = random_shape(random_);
  json surface = {
      {"name", "s" + std::to_string(hop)}, {"shape", next.shape}, {"optics", {{"type", "mirror"}}}};
  const auto local = place_on(surface, next);
  if (!local) return false;
  const geometry::Mat3 R =
      in_.aligned ? geometry::Mat3(geometry::Mat3::Identity()) : random_.rotation();
  x_ = ray_.o + ahead * ray_.w;
  surface["pose"] = pose_json({R, x_ - R * *local});
  const LongVec g = read_oracle_surface(surface, 1.0).gradient(x_.cast<Long>());
  if (std::abs(static_cast<double>(g.normalized().dot(ray_.w.cast<Long>()))) < 1e-3) return false;
  surface["aperture"] = aperture_about(x_, next.radius, true);
  return pass(surface);
}

void Maker::place_receiver() {
  double ahead = random_.log_uniform(0.3, 4.0);
  if (in_.screen == Screen::touching) ahead = std::pow(10.0, random_.uniform(-6.0, -1.0));
  Vec3 across = (ray_.w + 0.8 * random_.in_cube(1.0)).normalized();
  if (in_.screen == Screen::across) across = ray_.w;
  if (in_.screen == Screen::grazing)
    across = (random_.direction().cross(ray_.w).normalized() +
              std::pow(10.0, random_.uniform(-5.0, -1.0)) * ray_.w)
                 .normalized();
  if (in_.aligned && random_.index(2)) {
    int k = 0;
    ray_.w.cwiseAbs().maxCoeff(&k);
    across = Vec3::Unit(k);
  }
  const double width = random_.log_uniform(0.05, 5.0);
  Vec3 u = across.unitOrthogonal();
  if (!in_.aligned) u = Eigen::AngleAxisd(random_.uniform(0.0, 6.0), across) * u;
  if (in_.screen == Screen::through_focus) {
    // Where the bundle about the ray is thinnest: of a few tries the least area.
    json scene = {{"light", light_}, {"surfaces", surfaces_}, {"receiver", {}}};
    double least = geometry::kInfinity;
    for (int i = 0; i < 40; ++i) {
      const double t = random_.log_uniform(0.02, 5.0);
      scene["receiver"] = {{"type", "plane"},
                           {"origin", as_array(ray_.o + t * ray_.w)},
                           {"u_axis", as_array(u)},
                           {"v_axis", as_array(across.cross(u))},
                           {"size", {1.0, 1.0}}};
      const Oracle oracle(scene);
      Family family;
      for (std::size_t k = 0; k < names_.size(); ++k) family.push_back(static_cast<int>(k));
      std::vector<double> near{1.0};
      for (std::size_t k = 1; k < way_.size(); ++k) near.push_back((way_[k] - way_[k - 1]).norm());
      const auto reading = oracle.quick(family, way_[0], near);
      if (reading && 1.0 / reading->E < least) least = 1.0 / reading->E, ahead = t;
    }
  }
  const Vec3 v = across.cross(u);
  Point origin = ray_.o + ahead * ray_.w;
  if (!in_.aligned)
    origin += 0.4 * width * (random_.uniform(-1.0, 1.0) * u + random_.uniform(-1.0, 1.0) * v);
  receiver_ = {{"type", "plane"},
               {"origin", as_array(origin)},
               {"u_axis", as_array(u)},
               {"v_axis", as_array(v)},
               {"size", {width, width * random_.uniform(0.4, 1.0)}}};
}

void Maker::add_blockers() {
  for (int i = 0; i < in_.blockers; ++i) {
    const Point place = ray_.o + random_.uniform(0.1, 1.0) * ray_.w + random_.in_cube(0.5);
    const RandomShape shape = random_shape(random_);
    json surface = {{"name", "b" + std::to_string(i)},
                    {"shape", shape.shape},
                    {"optics", {{"type", "absorb"}}}};
    const geometry::Mat3 R = random_.rotation();
    surface["pose"] = pose_json({R, place - R * shape.middle});
    const double r = random_.log_uniform(0.05, 0.6);
    surface["aperture"] = {{{"type", "box"},
                            {"min", as_array(place - r * Vec3::Ones())},
                            {"max", as_array(place + r * Vec3::Ones())}}};
    surfaces_.push_back(surface);
  }
  if (!in_.twin) return;
  json twin = surfaces_[0];
  twin["name"] = "twin";
  const double by = std::pow(10.0, random_.uniform(-9.0, -1.0));
  const geometry::Pose pose = read_pose(twin, 1.0);
  twin["pose"] = pose_json({pose.rotation, pose.translation + by * random_.direction()});
  if (random_.index(2)) twin["optics"] = {{"type", "absorb"}};
  surfaces_.push_back(twin);
}

json Maker::levels() {
  if (random_.index(4)) return {{"count", 1 + random_.index(4)}};
  // The level through the path that the scene was built along, or next to it.
  const Oracle oracle({{"length_unit", unit_},
                       {"light", light_},
                       {"surfaces", surfaces_},
                       {"receiver", receiver_}});
  Family family;
  for (const std::string& name : names_) family.push_back(oracle.scene().index_of(name));
  const double metres = oracle.scene().metres;
  std::vector<double> near{metres};
  for (std::size_t k = 1; k < way_.size(); ++k)
    near.push_back(metres * (way_[k] - way_[k - 1]).norm());
  const auto reading = oracle.quick(family, metres * way_[0], near);
  if (!reading || !(reading->E > 1e-200) || !(reading->E < 1e200)) return {{"count", 3}};
  return {reading->E, 1.5 * reading->E};
}

json Maker::make() {
  if (!place_first()) return {};
  for (int hop = 1; hop < in_.hops; ++hop)
    if (!place_next(hop)) return {};
  place_receiver();
  add_blockers();
  const char* units[] = {"cm", "mm", "in", "ft"};
  if (random_.index(8) == 0) unit_ = units[random_.index(4)];
  json request = {{"scene", {{"light", light_}, {"surfaces", surfaces_}, {"receiver", receiver_}}},
                  {"levels", levels()},
                  {"measure", in_.total ? "total" : "sheet"},
                  {"tolerance", {{"chord", 1e-3 * receiver_["size"][0].get<double>()}}},
                  {"limits", {{"time_ms", 2000}, {"vertices", 100000}, {"cells", 2000}}}};
  if (random_.index(3) == 0)
    request["families"] = json::array({names_});
  else
    request["families"] = {{"max_bounces", in_.hops},
                           {"min_flux_share", random_.index(2) ? 0.0 : 1e-6}};
  // Totals of several hops may be beyond this version: then sheets are what is answered.
  if (in_.total && in_.hops > 1 && !in_.direct) request.erase("measure");
  if (in_.direct) request["direct"] = true;
  if (in_.certify) request["certify"] = true;
  if (random_.index(5) == 0) {
    request["include"] = {"isolux", "caustic", "critical_points"};
    if (in_.total && in_.hops == 1)
      request["include"].insert(request["include"].end(), {"boundaries", "regions"});
  }
  if (unit_ != std::string("m")) request["scene"]["length_unit"] = unit_;
  return in_.scale == 1.0 ? request : scaled(request, in_.scale);
}

/// Levels at the values of critical points, or hardly beside them.
void make_levels_critical(json& request, Random& random) {
  json question = request;
  question["include"] = {"critical_points", "isolux"};
  question["certify"] = false;
  question["limits"]["time_ms"] = 500;
  try {
    std::set<double> values;
    for (const auto& place : run_trial(question).result.critical_points) {
      const double beside = random.index(2) ? 0.0 : std::pow(10.0, random.uniform(-12.0, -2.0));
      values.insert(place.E * (1.0 + random.sign() * beside));
    }
    if (values.empty()) return;
    request["levels"] = json::array();
    for (const double value : values)
      if (request["levels"].size() < 4 && std::isfinite(value) && value > 1e-200)
        request["levels"].push_back(value);
    if (request["levels"].empty()) request["levels"] = {{"count", 2}};
  } catch (const service::ProblemError&) {
    // The request itself will be refused as well, and counted.
  }
}

}  // namespace

json random_request(std::uint64_t seed, std::uint64_t k) {
  Random random(seed * 1'000'003 + k);
  for (;;) {
    json request = Maker(random).make();
    if (request.is_null()) continue;
    if (random.index(10) == 0) make_levels_critical(request, random);
    return request;
  }
}

}  // namespace caustic::stress
