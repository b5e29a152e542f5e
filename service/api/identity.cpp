#include "service/api/identity.h"

#include <openssl/evp.h>
#include <openssl/rand.h>

#include <algorithm>
#include <stdexcept>

namespace caustic::service {
namespace {

constexpr std::size_t kBytes = 32;

std::string hex(const unsigned char* bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string out;
  for (std::size_t i = 0; i < kBytes; ++i) {
    out += kDigits[bytes[i] >> 4];
    out += kDigits[bytes[i] & 15];
  }
  return out;
}

}  // namespace

const char* const kEngineVersion = ISOCAUSTIC_VERSION;

std::string sha256_hex(std::string_view bytes) {
  unsigned char digest[kBytes];
  if (!EVP_Digest(bytes.data(), bytes.size(), digest, nullptr, EVP_sha256(), nullptr))
    throw std::runtime_error("SHA-256 failed");
  return hex(digest);
}

std::string random_id() {
  unsigned char bytes[kBytes];
  if (RAND_bytes(bytes, kBytes) != 1) throw std::runtime_error("no random bytes");
  return hex(bytes);
}

bool is_id(std::string_view text) {
  return text.size() == 2 * kBytes && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

}  // namespace caustic::service
