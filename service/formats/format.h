// The file formats, as one table. A writer is a pure function: the same set gives the same bytes,
// at any time and in any thread.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "service/formats/polyline_set.h"

namespace caustic::service {

struct Format {
  const char* suffix;  ///< without the dot
  const char* media_type;
  std::string (*write)(const PolylineSet& set);
};

std::span<const Format> formats();
/// Null if there is no such format.
const Format* find_format(std::string_view suffix);

std::string write_vtp(const PolylineSet& set);
std::string write_legacy_vtk(const PolylineSet& set);
std::string write_svg(const PolylineSet& set);
std::string write_geojson(const PolylineSet& set);
std::string write_csv(const PolylineSet& set);

}  // namespace caustic::service
