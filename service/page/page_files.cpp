#include "service/page/page_files.h"

#ifdef ISOCAUSTIC_PAGE
#include "page_data.h"  // made by web/build.cmake
#endif

namespace caustic::service {

std::span<const PageFile> page_files() {
#ifdef ISOCAUSTIC_PAGE
  return kPageFiles;
#else
  return {};
#endif
}

const PageFile* find_page_file(std::string_view path) {
  for (const PageFile& file : page_files())
    if (file.path == path) return &file;
  return nullptr;
}

}  // namespace caustic::service
