// What lets clients and caches keep an answer, and get it in fewer bytes.
#pragma once

#include <string>
#include <string_view>

#include "service/http/message.h"

namespace caustic::service {

/// `Cache-Control` of what never changes.
inline constexpr const char* kForever = "max-age=31536000, immutable";

/// True if `If-None-Match` of the request has this tag (RFC 9110, 13.1.2: weak comparison).
bool has_tag(const HttpRequest& request, std::string_view tag);

/// Adds `ETag` and says that the answer never changes; an answer with the tag that the client has
/// becomes a 304 without body.
HttpResponse immutable(const HttpRequest& request, std::string_view tag, HttpResponse response);
/// That 304.
HttpResponse not_modified(std::string_view tag);

/// The body as gzip, if the client takes that, the kind of content gains by it and it is not tiny;
/// and `Vary` either way.
void compress(const HttpRequest& request, HttpResponse& response);

/// What was compressed from `size` bytes.
std::string gunzip(std::string_view bytes, std::size_t size);

/// True if `Accept-Encoding` has gzip with a quality over 0.
bool accepts_gzip(std::string_view accept_encoding);

}  // namespace caustic::service
