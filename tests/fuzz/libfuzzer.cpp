// One target as a libFuzzer program; FUZZ_TARGET is its function. With --seeds DIR it writes its
// seed corpus there and ends.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  caustic::test::FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  return 0;
}

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (*argc != 3 || std::strcmp((*argv)[1], "--seeds") != 0) return 0;
  const std::filesystem::path folder = (*argv)[2];
  std::filesystem::create_directories(folder);
  for (const auto& target : caustic::test::fuzz_targets()) {
    if (target.run != caustic::test::FUZZ_TARGET) continue;
    int i = 0;
    for (const std::string& seed : target.seeds())
      std::ofstream(folder / ("seed" + std::to_string(i++)), std::ios::binary) << seed;
  }
  std::exit(0);
}
