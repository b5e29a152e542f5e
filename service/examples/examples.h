// Ready requests, embedded in the binary.
#pragma once

#include <span>
#include <string_view>

namespace caustic::service {

struct Example {
  std::string_view name, title;
  std::string_view body;  ///< a body for POST /v1/contours as it is
};

std::span<const Example> examples();
/// Null if there is none of this name.
const Example* find_example(std::string_view name);

/// The OpenAPI document of what is served.
std::string_view openapi_document();

}  // namespace caustic::service
