// The OpenAPI document as a page that people read: no script, nothing from elsewhere.
#pragma once

#include <string>
#include <string_view>

namespace caustic::service {

std::string docs_page(std::string_view openapi);

}  // namespace caustic::service
