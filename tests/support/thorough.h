// How many examples a test takes. A sanitizer watches for faults that a few examples show as well
// as many do, and makes each of them five to fifteen times as long: digits are judged by the plain
// build.
#pragma once

namespace caustic::test {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// `all` examples, or `few` under a sanitizer.
constexpr int thorough(int all, int few) { return kSanitized ? few : all; }

}  // namespace caustic::test
