// Names of requests and results.
#pragma once

#include <string>
#include <string_view>

namespace caustic::service {

/// The release number; part of every result's identity.
extern const char* const kEngineVersion;

/// 64 lower-case hexadecimal digits.
std::string sha256_hex(std::string_view bytes);
/// The same shape, from the system's random source.
std::string random_id();
bool is_id(std::string_view text);

}  // namespace caustic::service
