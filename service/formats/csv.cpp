#include "service/api/json_text.h"
#include "service/formats/format.h"

namespace caustic::service {
namespace {

constexpr const char* kHeader =
    "curve_id,kind,level,closed,family_id,parity,vertex,x,y,z,u,v,irradiance,residual,"
    "gradient_x,gradient_y,gradient_z,arc_length,x1,y1,z1\n";

template <std::size_t N>
void append(std::string& row, const std::array<double, N>& values) {
  for (double value : values) append_number(row += ',', value);
}

}  // namespace

std::string write_csv(const PolylineSet& set) {
  std::string out = kHeader;
  for (std::size_t id = 0; id < set.curves.size(); ++id) {
    const Polyline& curve = set.curves[id];
    std::string cell =
        std::to_string(id) + ',' + std::to_string(static_cast<int>(curve.kind)) + ',';
    append_number(cell, curve.level);
    cell += std::string(",") + (curve.closed ? "1" : "0") + ',' + std::to_string(curve.family_id) +
            ',' + std::to_string(curve.parity) + ',';
    for (std::uint64_t i = 0; i < curve.file_vertices(); ++i) {
      const PolylineVertex& vertex = set.vertex(curve, i);
      out.append(cell).append(std::to_string(i));
      append(out, vertex.position);
      append(out, vertex.uv);
      append(out, std::array{vertex.irradiance, vertex.residual});
      append(out, vertex.gradient);
      append_number(out += ',', i == curve.count ? curve.length : vertex.arc_length);
      append(out, vertex.reflector_point);
      out += '\n';
    }
  }
  return out;
}

}  // namespace caustic::service
