// The files of the page, embedded in the binary; none in a build without it (ISOCAUSTIC_PAGE=OFF).
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace caustic::service {

struct PageFile {
  std::string_view path;  ///< where it is served
  std::string_view content_type;
  std::string_view tag;   ///< of its bytes
  std::size_t size;       ///< in bytes
  std::string_view gzip;  ///< the bytes, compressed when the page was built
};

std::span<const PageFile> page_files();
/// Null if there is none at this path.
const PageFile* find_page_file(std::string_view path);

}  // namespace caustic::service
