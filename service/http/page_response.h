// A file of the page as an answer.
#pragma once

#include "service/http/message.h"
#include "service/page/page_files.h"

namespace caustic::service {

/// Under a Content-Security-Policy by which the page runs its own scripts and talks to this
/// service, and nothing else. What is named by its content is kept for ever, the rest asked for
/// again.
HttpResponse page_response(const HttpRequest& request, const PageFile& file);

}  // namespace caustic::service
