#include "service/api/path_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "service/api/family_json.h"
#include "service/api/json_text.h"
#include "service/api/scene_json.h"
#include "service/api/vector_json.h"

namespace caustic::service {
namespace {

using geometry::Mat3;
using geometry::Point;
using geometry::Vec3;
using nlohmann::json;
using nlohmann::ordered_json;

ordered_json points_json(const std::vector<Point>& points, double scale) {
  auto out = ordered_json::array();
  for (const Point& x : points) out.push_back(vector_json(x, scale));
  return out;
}

ordered_json matrix_json(const Mat3& m, double scale) {
  auto out = ordered_json::array();
  for (int row = 0; row < 3; ++row) out.push_back(vector_json(m.row(row), scale));
  return out;
}

/// Jacobians have no unit, Hessians are per length. Null where there are none: on a caustic.
void add_derivatives(ordered_json& out, const solver::PathDerivatives& d, double metres,
                     bool hessians) {
  out["determinant"] = std::isfinite(d.determinant)
                           ? ordered_json(d.determinant / (metres * metres))
                           : ordered_json();
  out["jacobians"] = nullptr;
  if (hessians) out["hessians"] = nullptr;
  if (!d.finite) return;
  out["jacobians"] = ordered_json::array();
  for (const Mat3& J : d.jacobians) out["jacobians"].push_back(matrix_json(J, 1.0));
  if (!hessians) return;
  out["hessians"] = ordered_json::array();
  for (const auto& H : d.hessians) {
    auto layers = ordered_json::array();
    for (const Mat3& layer : H) layers.push_back(matrix_json(layer, metres));
    out["hessians"].push_back(layers);
  }
}

ordered_json prediction_json(const solver::PathPrediction& p, double metres) {
  const double scale = 1.0 / metres;
  ordered_json out{{"first_order", points_json(p.first, scale)},
                   {"second_order", points_json(p.second, scale)},
                   {"exact", nullptr},
                   {"first_order_error", nullptr},
                   {"second_order_error", nullptr}};
  if (!p.converged) return out;
  out["exact"] = points_json(p.exact.x, scale);
  out["first_order_error"] = p.first_error * scale;
  out["second_order_error"] = p.second_error * scale;
  return out;
}

}  // namespace

PathCall read_path_call(std::string_view body) {
  json document = parse_json(body);
  Faults faults;
  Scene scene;
  solver::PathsRequest request;
  {
    ObjectReader root({&document, ""}, faults);
    if (const auto place = root.member("scene")) scene = read_scene(*place, faults);
    const double metres = scene.units.length.metres;
    request.from = metres * root.vector("from");
    request.to = metres * root.vector("to");
    if (faults.none() && request.from == request.to) {
      faults.add(root.pointer_to("to"), "must not be the point that `from` is");
    }
    const FamilyRequest families = read_families(root, scene);
    request.families = families.listed;
    request.max_bounces = families.max_bounces;
    request.hessians = root.boolean_or("hessians", false);
    request.certify = root.boolean_or("certify", false);
    if (root.optional_member("perturb")) request.shift = metres * root.vector("perturb");
  }
  faults.throw_if_any();
  return {solver::OpticalSystem::build(scene.light, std::move(scene.surfaces), scene.receiver),
          std::move(request), scene.units};
}

std::string path_answer(const PathCall& call, const solver::PathsResult& result) {
  const double metres = call.units.length.metres;
  auto paths = ordered_json::array();
  for (const solver::PathFound& found : result.paths) {
    ordered_json out{{"family_id", found.family_id},
                     {"vertices", points_json(found.way.path.x, 1.0 / metres)},
                     {"optical_length", found.optical_length / metres}};
    add_derivatives(out, found.derivatives, metres, call.request.hessians);
    if (call.request.shift) {
      out["prediction"] =
          found.prediction ? prediction_json(*found.prediction, metres) : ordered_json();
    }
    paths.push_back(std::move(out));
  }
  return write_json(ordered_json{
      {"paths", std::move(paths)},
      {"completeness", {{"certified", result.certified}, {"undecided_cells", result.undecided}}}});
}

}  // namespace caustic::service
