// A set of curves for tests of formats and records.
#pragma once

#include <cmath>

#include "service/formats/polyline_set.h"

namespace caustic::test {

/// Two closed isolux curves and an open caustic; numbers with all their digits.
inline service::PolylineSet sample_polylines() {
  using service::PolylineKind;
  service::PolylineSet set;
  set.receiver_size = {4, 3};
  set.length_unit = "mm";
  set.irradiance_unit = "W/m2";
  set.quantity = "irradiance";
  set.scene_json = R"({"name":"<&\"'> é 😀 ]]> % \\"})";
  set.units_json = R"({"length":"mm"})";
  set.engine_version = "0.1.0";
  set.request_sha256 = std::string(64, 'a');
  for (int id = 0; id < 3; ++id) {
    const bool caustic = id == 2;
    const std::uint64_t first = set.vertices.size(), count = 50;
    for (std::uint64_t i = 0; i < count; ++i) {
      const double t = 2 * 3.14159265358979 * static_cast<double>(i) / static_cast<double>(count);
      const double r = 0.4 * (id + 1);
      set.vertices.push_back({{r * std::cos(t), r * std::sin(t), 1.0 / 3.0},
                              {r * std::cos(t), r * std::sin(t)},
                              caustic ? -1.0 : 0.1 * (id + 1),
                              1e-13 * t,
                              {caustic ? 0.0 : std::sqrt(2.0), 0, 0},
                              r * t,
                              {0.1, 0.2, 0.3},
                              caustic ? -1.0 : 0.1 * (id + 1),
                              caustic ? -1.0 : 0.1 * (id + 1)});
    }
    service::Polyline curve;
    curve.kind = caustic ? PolylineKind::caustic : PolylineKind::isolux;
    curve.closed = !caustic;
    curve.parity = caustic ? 0 : 1;
    curve.level = caustic ? -1.0 : 0.1 * (id + 1);
    curve.length = 2.5 * (id + 1);
    curve.first = first;
    curve.count = count;
    set.curves.push_back(curve);
  }
  return set;
}

}  // namespace caustic::test
