// A result as it lies on disk: the answer, word for word, and the curves from which every file
// format is derived. One block of bytes with a checksum at its end; little-endian, as every machine
// we build for.
//
//   magic   8 bytes, with the layout's version
//   sizes   4 × uint64: labels, answer (bytes), curves, vertices (items)
//   labels  JSON: the strings of the PolylineSet
//   answer  JSON
//   curves, vertices   arrays of Polyline, PolylineVertex as in memory
//   sha256  64 hexadecimal digits, of everything before
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "service/formats/polyline_set.h"

namespace caustic::service {

struct ResultRecord {
  std::string answer;
  PolylineSet curves;
};

std::string encode(const ResultRecord& record);

/// Nothing if the bytes are not a whole record of this layout.
std::optional<ResultRecord> decode(std::string_view bytes);
/// The answer alone.
std::optional<std::string> decode_answer(std::string_view bytes);

/// True if a file of this size that begins so can be whole: cheap, no checksum.
bool size_fits(std::string_view beginning, std::uint64_t file_size);
constexpr std::size_t kRecordHeaderSize = 40;

}  // namespace caustic::service
