#include "service/http/request_head.h"

#include <algorithm>
#include <array>
#include <charconv>

namespace caustic::service {
namespace {

[[noreturn]] void refuse_head(int status, const char* detail) {
  throw ProblemError(make_problem(status, detail));
}

bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
bool is_visible(char c) { return c > ' ' && c < '\x7f'; }

/// RFC 9110, 5.6.2.
bool is_token(std::string_view text) {
  constexpr std::string_view kMarks = "!#$%&'*+-.^_`|~";
  return !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
    return is_upper(c) || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
           kMarks.find(c) != kMarks.npos;
  });
}

/// Bytes over 0x7f are opaque (RFC 9110, 5.5).
bool is_value(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) {
    return c == '\t' || (static_cast<unsigned char>(c) >= ' ' && c != '\x7f');
  });
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (is_upper(c)) c = static_cast<char>(c - 'A' + 'a');
  return out;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t";
  const auto begin = text.find_first_not_of(kBlank);
  if (begin == text.npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

/// The next line without its CRLF.
std::string_view take_line(std::string_view& rest) {
  const auto end = rest.find("\r\n");
  if (end == rest.npos) refuse_head(400, "a line of the head does not end in CRLF");
  const std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end + 2);
  return line;
}

void read_request_line(std::string_view line, RequestHead& head) {
  const auto first = line.find(' '), last = line.rfind(' ');
  if (first == line.npos || first == last) refuse_head(400, "the request line is not one");
  const std::string_view method = line.substr(0, first);
  const std::string_view target = line.substr(first + 1, last - first - 1);
  const std::string_view version = line.substr(last + 1);
  if (method.empty() || method.size() > 20 || !std::all_of(method.begin(), method.end(), is_upper))
    refuse_head(400, "the method is not one");
  if (target.empty() || !std::all_of(target.begin(), target.end(), is_visible))
    refuse_head(400, "the target is not one");
  if (target.size() > kMaxTargetBytes) refuse_head(414, "the path is too long");
  if (version != "HTTP/1.1" && version != "HTTP/1.0") {
    if (version.starts_with("HTTP/")) refuse_head(505, "only HTTP/1.1 and HTTP/1.0 are spoken");
    refuse_head(400, "the request line is not one");
  }
  head.method = method;
  head.target = target;
  head.keep_alive = version == "HTTP/1.1";
}

void read_header(std::string_view line, RequestHead& head, std::size_t count) {
  if (count > kMaxHeaders) refuse_head(431, "there are too many headers");
  const auto colon = line.find(':');
  if (colon == line.npos || !is_token(line.substr(0, colon)))
    refuse_head(400, "a header has no proper name");
  const std::string_view value = trimmed(line.substr(colon + 1));
  if (!is_value(value)) refuse_head(400, "a header's value has control characters");
  std::string name = lower(line.substr(0, colon));
  // Behind a gateway REMOTE_ADDR and Remote-Addr are one: what is not written so is not meant so.
  if (name.find('_') == name.npos) head.headers.emplace_back(std::move(name), value);
}

bool has_header(const RequestHead& head, std::string_view name) {
  return std::any_of(head.headers.begin(), head.headers.end(),
                     [&](const auto& header) { return header.first == name; });
}

void check_single_headers(const RequestHead& head) {
  constexpr std::array kOnce = {
      "host",          "content-length", "transfer-encoding", "content-type", "content-encoding",
      "authorization", "expect",         "x-request-id",      "origin",       "range"};
  for (const char* name : kOnce)
    if (std::count_if(head.headers.begin(), head.headers.end(),
                      [&](const auto& header) { return header.first == name; }) > 1)
      refuse_head(400, "a header that may come once comes twice");
}

void check_ranges(std::string_view ranges) {
  if (static_cast<std::size_t>(std::count(ranges.begin(), ranges.end(), ',')) >= kMaxRanges)
    refuse_head(416, "the answer comes whole, not in so many parts");
}

void read_length(std::string_view text, RequestHead& head) {
  std::uint64_t length = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), length);
  if (error == std::errc::result_out_of_range) refuse_head(413, "the body is too large");
  if (error != std::errc() || end != text.data() + text.size())
    refuse_head(400, "Content-Length is not a number");
  head.length = length;
}

void read_framing(RequestHead& head, bool is_1_0) {
  if (has_header(head, "transfer-encoding")) {
    if (has_header(head, "content-length") || is_1_0)
      refuse_head(400, "the length of the body is unclear");
    if (lower(head.header("transfer-encoding")) != "chunked")
      refuse_head(400, "no transfer coding but chunked is read");
    head.chunked = true;
  }
  if (has_header(head, "content-length")) read_length(head.header("content-length"), head);
  const std::string coding = lower(head.header("content-encoding"));
  if (!coding.empty() && coding != "identity") refuse_head(415, "bodies are read uncompressed");
  const bool has_body = head.chunked || head.length.value_or(0) > 0;
  for (const char* method : {"GET", "HEAD", "DELETE", "OPTIONS", "TRACE"})
    if (has_body && head.method == method) refuse_head(400, "this method has no body");
}

void read_connection(RequestHead& head) {
  const std::string options = lower(head.header("connection"));
  if (options.find("close") != options.npos)
    head.keep_alive = false;
  else if (options.find("keep-alive") != options.npos)
    head.keep_alive = true;
  const std::string expected = lower(head.header("expect"));
  if (!expected.empty() && expected != "100-continue")
    refuse_head(417, "nothing but 100-continue can be expected");
  head.expects_continue = !expected.empty() && (head.chunked || head.length.value_or(0) > 0);
}

}  // namespace

std::string_view RequestHead::header(std::string_view name) const {
  for (const auto& [key, value] : headers)
    if (key == name) return value;
  return {};
}

RequestHead parse_request_head(std::string_view bytes) {
  RequestHead head;
  std::string_view rest = bytes;
  read_request_line(take_line(rest), head);
  const bool is_1_0 = !head.keep_alive;
  std::size_t count = 0;
  while (true) {
    const std::string_view line = take_line(rest);
    if (line.empty()) break;
    read_header(line, head, ++count);
  }
  if (!rest.empty()) refuse_head(400, "the head goes on after its end");
  check_single_headers(head);
  if (!is_1_0 && !has_header(head, "host")) refuse_head(400, "there is no Host");
  check_ranges(head.header("range"));
  read_framing(head, is_1_0);
  read_connection(head);
  return head;
}

}  // namespace caustic::service
