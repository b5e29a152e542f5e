#include "service/results/result_record.h"

#include <cstring>
#include <nlohmann/json.hpp>

#include "service/api/identity.h"

namespace caustic::service {
namespace {

constexpr char kMagic[] = "isolux02";
constexpr std::size_t kChecksumSize = 64;

struct Sizes {
  std::uint64_t labels, answer, curves, vertices;
};
static_assert(8 + sizeof(Sizes) == kRecordHeaderSize);

/// Sizes of a hostile header may overflow: no size can be beyond that of the file.
std::optional<Sizes> read_sizes(std::string_view beginning, std::uint64_t file_size) {
  if (beginning.size() < kRecordHeaderSize || beginning.substr(0, 8) != kMagic) return std::nullopt;
  Sizes sizes;
  std::memcpy(&sizes, beginning.data() + 8, sizeof sizes);
  for (std::uint64_t size : {sizes.labels, sizes.answer, sizes.curves, sizes.vertices})
    if (size > file_size) return std::nullopt;
  const std::uint64_t total = kRecordHeaderSize + sizes.labels + sizes.answer +
                              sizes.curves * sizeof(Polyline) +
                              sizes.vertices * sizeof(PolylineVertex) + kChecksumSize;
  if (total != file_size) return std::nullopt;
  return sizes;
}

std::optional<Sizes> check(std::string_view bytes) {
  const auto sizes = read_sizes(bytes, bytes.size());
  if (!sizes) return std::nullopt;
  const std::string_view content = bytes.substr(0, bytes.size() - kChecksumSize);
  if (sha256_hex(content) != bytes.substr(content.size())) return std::nullopt;
  return sizes;
}

std::string labels_json(const PolylineSet& set) {
  return nlohmann::json{set.length_unit,    set.irradiance_unit,  set.quantity,
                        set.scene_json,     set.units_json,       set.engine_version,
                        set.request_sha256, set.receiver_size[0], set.receiver_size[1],
                        set.total}
      .dump();
}

void read_labels(std::string_view text, PolylineSet& set) {
  const auto labels = nlohmann::json::parse(text);
  int next = 0;
  for (std::string* label : {&set.length_unit, &set.irradiance_unit, &set.quantity, &set.scene_json,
                             &set.units_json, &set.engine_version, &set.request_sha256})
    *label = labels[next++];
  for (double& size : set.receiver_size) size = labels[next++];
  set.total = labels[next];
}

template <typename Item>
void append_items(std::string& out, const std::vector<Item>& items) {
  out.append(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(Item));
}

template <typename Item>
std::vector<Item> take_items(std::string_view& rest, std::uint64_t count) {
  std::vector<Item> out(count);
  if (count) std::memcpy(out.data(), rest.data(), count * sizeof(Item));
  rest.remove_prefix(count * sizeof(Item));
  return out;
}

}  // namespace

std::string encode(const ResultRecord& record) {
  const PolylineSet& set = record.curves;
  const std::string labels = labels_json(set);
  const Sizes sizes{labels.size(), record.answer.size(), set.curves.size(), set.vertices.size()};
  std::string out;
  out.reserve(kRecordHeaderSize + labels.size() + record.answer.size() + kChecksumSize +
              set.curves.size() * sizeof(Polyline) + set.vertices.size() * sizeof(PolylineVertex));
  out.append(kMagic, 8).append(reinterpret_cast<const char*>(&sizes), sizeof sizes);
  out.append(labels).append(record.answer);
  append_items(out, set.curves);
  append_items(out, set.vertices);
  return out += sha256_hex(out);
}

std::optional<ResultRecord> decode(std::string_view bytes) {
  const auto sizes = check(bytes);
  if (!sizes) return std::nullopt;
  std::string_view rest = bytes.substr(kRecordHeaderSize);
  ResultRecord out;
  read_labels(rest.substr(0, sizes->labels), out.curves);
  out.answer = rest.substr(sizes->labels, sizes->answer);
  rest.remove_prefix(sizes->labels + sizes->answer);
  out.curves.curves = take_items<Polyline>(rest, sizes->curves);
  out.curves.vertices = take_items<PolylineVertex>(rest, sizes->vertices);
  return out;
}

std::optional<std::string> decode_answer(std::string_view bytes) {
  const auto sizes = check(bytes);
  if (!sizes) return std::nullopt;
  return std::string(bytes.substr(kRecordHeaderSize + sizes->labels, sizes->answer));
}

bool size_fits(std::string_view beginning, std::uint64_t file_size) {
  return read_sizes(beginning, file_size).has_value();
}

}  // namespace caustic::service
