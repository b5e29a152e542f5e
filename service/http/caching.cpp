#include "service/http/caching.h"

#include <zlib.h>

#include <algorithm>
#include <stdexcept>

namespace caustic::service {
namespace {

// Below it a packet is not filled anyway; above it the time to compress is not worth it.
constexpr std::size_t kSmallestCompressed = 1000, kLargestCompressed = 32u << 20;
constexpr int kGzipLevel = 1;  // 4 MiB of JSON in 40 ms; the best level takes ten times as long
constexpr int kGzipWindow = 15 + 16;

std::string_view stripped(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t");
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// Calls `use` with each element of a list, without the blanks around it.
template <typename Use>
void for_each_element(std::string_view list, Use use) {
  while (!list.empty()) {
    const auto comma = std::min(list.find(','), list.size());
    use(stripped(list.substr(0, comma)));
    list.remove_prefix(std::min(comma + 1, list.size()));
  }
}

/// Unquoted tags are compared as they are; none of ours has a quote or a comma in it.
std::string quoted(std::string_view tag) { return '"' + std::string(tag) + '"'; }

std::string gzip(std::string_view bytes) {
  z_stream stream{};
  if (deflateInit2(&stream, kGzipLevel, Z_DEFLATED, kGzipWindow, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::runtime_error("deflateInit2");
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int status = deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  if (status != Z_STREAM_END) throw std::runtime_error("deflate");
  return out;
}

bool gains_by_compression(std::string_view type) {
  return type.find("json") != type.npos || type.starts_with("text/") || type == "image/svg+xml" ||
         type == "application/x-vtk-legacy";
}

}  // namespace

bool has_tag(const HttpRequest& request, std::string_view tag) {
  const std::string ours = quoted(tag);
  const std::string_view asked = request.header("if-none-match");
  bool found = stripped(asked) == "*";
  for_each_element(asked, [&](std::string_view element) {
    if (element.starts_with("W/")) element.remove_prefix(2);
    // Compressed by us, it was sent with a tag of its own.
    found = found || element == ours || element == quoted(std::string(tag) + "-gzip");
  });
  return found;
}

HttpResponse not_modified(std::string_view tag) {
  return {304, "", "", {{"ETag", quoted(tag)}, {"Cache-Control", kForever}}};
}

HttpResponse immutable(const HttpRequest& request, std::string_view tag, HttpResponse response) {
  if (has_tag(request, tag)) return not_modified(tag);
  response.headers.emplace_back("ETag", quoted(tag));
  response.headers.emplace_back("Cache-Control", kForever);
  compress(request, response);
  return response;
}

void compress(const HttpRequest& request, HttpResponse& response) {
  if (!gains_by_compression(response.content_type)) return;
  response.headers.emplace_back("Vary", "Accept-Encoding");
  if (!accepts_gzip(request.header("accept-encoding")) ||
      response.body.size() < kSmallestCompressed || response.body.size() > kLargestCompressed)
    return;
  response.body = gzip(response.body);
  response.headers.emplace_back("Content-Encoding", "gzip");
  for (auto& [name, value] : response.headers)
    if (name == "ETag") value.insert(value.size() - 1, "-gzip");
}

std::string gunzip(std::string_view bytes, std::size_t size) {
  z_stream stream{};
  if (inflateInit2(&stream, kGzipWindow) != Z_OK) throw std::runtime_error("inflateInit2");
  std::string out(size, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int status = inflate(&stream, Z_FINISH);
  const bool whole = stream.total_out == size;
  inflateEnd(&stream);
  if (status != Z_STREAM_END || !whole) throw std::runtime_error("inflate");
  return out;
}

bool accepts_gzip(std::string_view accept_encoding) {
  bool named = false, accepted = false, any = false;
  for_each_element(accept_encoding, [&](std::string_view element) {
    const auto semicolon = std::min(element.find(';'), element.size());
    const std::string_view coding = stripped(element.substr(0, semicolon));
    std::string_view quality = element.substr(semicolon);
    const auto value = quality.find("q=");
    // "0", "0.", "0.000": no digit but 0.
    const bool wanted = value == quality.npos ||
                        quality.substr(value + 2).find_first_of("123456789") != quality.npos;
    if (coding == "gzip" || coding == "x-gzip") named = true, accepted = wanted;
    if (coding == "*") any = wanted;
  });
  return named ? accepted : any;
}

}  // namespace caustic::service
