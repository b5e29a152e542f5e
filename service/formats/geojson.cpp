#include <nlohmann/json.hpp>

#include "service/api/json_text.h"
#include "service/formats/format.h"

namespace caustic::service {
namespace {

using nlohmann::ordered_json;

std::string properties(const Polyline& curve, std::size_t id, bool total) {
  ordered_json out{{"curve_id", id},
                   {"kind", word(curve.kind)},
                   {"level", curve.has_level() ? ordered_json(curve.level) : ordered_json()},
                   {"closed", curve.closed != 0},
                   {"family_id", curve.family_id},
                   {"parity", curve.parity},
                   {"length", curve.length}};
  if (total) {
    out["boundary"] = curve.boundary;
    out["ring_id"] = curve.ring_id;
    out["ring_order"] = curve.ring_order;
  }
  return write_json(out);
}

}  // namespace

std::string write_geojson(const PolylineSet& set) {
  std::string out = R"({"type":"FeatureCollection","features":[)";
  for (std::size_t id = 0; id < set.curves.size(); ++id) {
    const Polyline& curve = set.curves[id];
    out += id ? ",\n" : "\n";
    out += R"({"type":"Feature","properties":)" + properties(curve, id, set.total) +
           R"(,"geometry":{"type":"LineString","coordinates":[)";
    for (std::uint64_t i = 0; i < curve.file_vertices(); ++i) {
      const PolylineVertex& vertex = set.vertex(curve, i);
      append_number(out += i ? ",[" : "[", vertex.uv[0]);
      append_number(out += ',', vertex.uv[1]);
      out += ']';
    }
    out += "]}}";
  }
  return out + "\n]}\n";
}

}  // namespace caustic::service
