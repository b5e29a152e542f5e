#include "service/http/page_response.h"

#include "service/http/caching.h"

namespace caustic::service {
namespace {

// data: pictures are those of Swagger UI's style sheet.
constexpr const char* kPagePolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

}  // namespace

HttpResponse page_response(const HttpRequest& request, const PageFile& file) {
  const bool named_by_content = file.path.starts_with("/assets/");
  const bool packed = accepts_gzip(request.header("accept-encoding"));
  const std::string tag = '"' + std::string(file.tag) + (packed ? "-gzip\"" : "\"");
  HttpHeaders headers = {{"ETag", tag},
                         {"Cache-Control", named_by_content ? kForever : "no-cache"},
                         {"Vary", "Accept-Encoding"},
                         {"Content-Security-Policy", kPagePolicy},
                         {"Referrer-Policy", "no-referrer"}};
  if (has_tag(request, file.tag)) return {304, "", "", std::move(headers)};
  if (packed) headers.emplace_back("Content-Encoding", "gzip");
  return {200, std::string(file.content_type),
          packed ? std::string(file.gzip) : gunzip(file.gzip, file.size), std::move(headers)};
}

}  // namespace caustic::service
