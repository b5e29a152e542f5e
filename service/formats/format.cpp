#include "service/formats/format.h"

namespace caustic::service {
namespace {

constexpr Format kFormats[] = {
    {"vtp", "application/x-vtk-polydata", write_vtp},
    {"vtk", "application/x-vtk-legacy", write_legacy_vtk},
    {"svg", "image/svg+xml", write_svg},
    {"geojson", "application/geo+json", write_geojson},
    {"csv", "text/csv", write_csv},
};

}  // namespace

std::span<const Format> formats() { return kFormats; }

const Format* find_format(std::string_view suffix) {
  for (const Format& format : kFormats)
    if (suffix == format.suffix) return &format;
  return nullptr;
}

}  // namespace caustic::service
