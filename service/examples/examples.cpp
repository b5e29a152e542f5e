#include "service/examples/examples.h"

#include "embedded.h"  // made by embed.cmake

namespace caustic::service {

std::span<const Example> examples() { return kEmbeddedExamples; }

const Example* find_example(std::string_view name) {
  for (const Example& example : kEmbeddedExamples)
    if (example.name == name) return &example;
  return nullptr;
}

std::string_view openapi_document() { return kEmbeddedOpenapi; }

}  // namespace caustic::service
