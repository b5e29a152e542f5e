#include "service/api/irradiance_json.h"

#include <nlohmann/json.hpp>

#include "service/api/family_json.h"
#include "service/api/json_text.h"
#include "service/api/scene_json.h"
#include "service/api/vector_json.h"
#include "solver/itineraries.h"

namespace caustic::service {
namespace {

using geometry::Vec2;
using nlohmann::json;
using nlohmann::ordered_json;

// A point given on the receiver's edge may be beyond it by rounding.
constexpr double kEdgeShare = 1e-12;

void read_point(const JsonPlace& place, const Scene& scene, std::vector<Vec2>& points,
                Faults& faults) {
  const std::size_t before = faults.count();
  const auto uv = read_numbers(place, 2, kAnyNumber, faults);
  if (faults.count() != before) return;
  const Vec2 q = scene.units.length.metres * Vec2(uv[0], uv[1]);
  const Vec2 half = (1.0 + kEdgeShare) * scene.receiver.half;
  if (faults.none() && (q.cwiseAbs().array() > half.array()).any())
    faults.add(place.pointer, "lies outside of the receiver");
  points.push_back(q);
}

/// Cell centres, rows of v, u fastest.
void read_grid(const JsonPlace& place, const Scene& scene, std::vector<Vec2>& points,
               Faults& faults) {
  ObjectReader grid(place, faults);
  const std::size_t before = faults.count();
  int count[2] = {1, 1};
  const char* keys[2] = {"nu", "nv"};
  for (int i = 0; i < 2; ++i) {
    if (const auto member = grid.member(keys[i]))
      count[i] = read_integer(*member, 1, kMaxPoints, faults);
  }
  if (faults.count() != before) return;
  if (static_cast<double>(count[0]) * count[1] > kMaxPoints)
    return faults.add(place.pointer, "more than " + std::to_string(kMaxPoints) + " points");
  for (int j = 0; j < count[1]; ++j) {
    for (int i = 0; i < count[0]; ++i) {
      points.push_back({((2.0 * i + 1.0) / count[0] - 1.0) * scene.receiver.half.x(),
                        ((2.0 * j + 1.0) / count[1] - 1.0) * scene.receiver.half.y()});
    }
  }
}

std::vector<Vec2> read_places(ObjectReader& root, const Scene& scene) {
  Faults& faults = root.faults();
  std::vector<Vec2> points;
  const auto list = root.optional_member("points"), grid = root.optional_member("grid");
  if (list && grid) {
    faults.add(grid->pointer, "either points or grid, not both");
  } else if (list) {
    for (const JsonPlace& place : read_elements(*list, kMaxPoints, faults))
      read_point(place, scene, points, faults);
    if (list->value->is_array() && list->value->empty())
      faults.add(list->pointer, "needs at least one point");
  } else if (grid) {
    read_grid(*grid, scene, points, faults);
  } else {
    faults.add(root.pointer_to("points"), "missing: points or grid");
  }
  return points;
}

ordered_json sheet_json(const solver::SheetIrradiance& sheet, double metres) {
  auto vertices = ordered_json::array();
  for (const auto& x : sheet.hits) vertices.push_back(vector_json(x, 1.0 / metres));
  return {{"family_id", sheet.family_id},
          {"parity", sheet.parity},
          {"E", sheet.E},
          {"gradient", vector_json(sheet.gradient, metres)},
          {"x", vector_json(sheet.x, 1.0 / metres)},
          {"vertices", std::move(vertices)}};
}

}  // namespace

IrradianceCall read_irradiance_call(std::string_view body) {
  json document = parse_json(body);
  Faults faults;
  Scene scene;
  FamilyRequest families;
  std::vector<Vec2> points;
  bool direct = false;
  {
    ObjectReader root({&document, ""}, faults);
    if (const auto place = root.member("scene")) scene = read_scene(*place, faults);
    families = read_families(root, scene);
    direct = root.boolean_or("direct", false);
    points = read_places(root, scene);
  }
  faults.throw_if_any();
  auto system =
      solver::OpticalSystem::build(scene.light, std::move(scene.surfaces), scene.receiver);
  if (families.listed.empty())
    families.listed = solver::families_up_to(system, families.max_bounces);
  return {std::move(system), std::move(families.listed), direct, std::move(points), scene.units};
}

std::string irradiance_answer(const IrradianceCall& call,
                              const std::vector<solver::PointIrradiance>& readings) {
  const double metres = call.units.length.metres;
  auto points = ordered_json::array();
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const solver::PointIrradiance& reading = readings[i];
    auto sheets = ordered_json::array();
    for (const auto& sheet : reading.sheets) sheets.push_back(sheet_json(sheet, metres));
    points.push_back({{"uv", {call.points[i].x() / metres, call.points[i].y() / metres}},
                      {"E", reading.on_caustic ? ordered_json() : ordered_json(reading.E)},
                      {"gradient", vector_json(reading.gradient, metres)},
                      {"on_caustic", reading.on_caustic},
                      {"sheets", std::move(sheets)}});
  }
  return write_json(ordered_json{{"points", std::move(points)}});
}

}  // namespace caustic::service
