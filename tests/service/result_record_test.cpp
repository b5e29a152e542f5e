#include "service/results/result_record.h"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/support/polylines.h"

namespace caustic::service {
namespace {

const ResultRecord& sample() {
  static const ResultRecord record{R"({"id":"é"})", test::sample_polylines()};
  return record;
}

TEST(ResultRecord, comes_back_as_it_was) {
  const auto back = decode(encode(sample()));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->answer, sample().answer);
  const PolylineSet &a = back->curves, &b = sample().curves;
  EXPECT_EQ(a.scene_json, b.scene_json);
  EXPECT_EQ(a.receiver_size, b.receiver_size);
  ASSERT_EQ(a.curves.size(), b.curves.size());
  ASSERT_EQ(a.vertices.size(), b.vertices.size());
  EXPECT_EQ(std::memcmp(a.curves.data(), b.curves.data(), a.curves.size() * sizeof(Polyline)), 0);
  EXPECT_EQ(
      std::memcmp(a.vertices.data(), b.vertices.data(), a.vertices.size() * sizeof(PolylineVertex)),
      0);
  EXPECT_EQ(encode(*back), encode(sample()));
  EXPECT_EQ(decode_answer(encode(sample())), sample().answer);
}

TEST(ResultRecord, is_whole_or_nothing) {
  const std::string bytes = encode(sample());
  for (std::size_t size = 0; size < bytes.size(); size += size < 300 ? 1 : 97)
    EXPECT_FALSE(decode(std::string_view(bytes).substr(0, size))) << size;
  EXPECT_FALSE(decode(bytes + '\0'));
  for (std::size_t i = 0; i < bytes.size(); i += i < 300 ? 1 : 97) {
    std::string damaged = bytes;
    damaged[i] ^= 1;
    EXPECT_FALSE(decode(damaged)) << i;
    EXPECT_FALSE(decode_answer(damaged)) << i;
  }
}

TEST(ResultRecord, sizes_cannot_lie) {
  std::string bytes = encode(sample());
  for (int field = 0; field < 4; ++field) {
    for (const std::uint64_t lie : {~0ull, ~0ull / sizeof(PolylineVertex) + 1, 1ull << 60, 0ull}) {
      std::string lying = bytes;
      std::memcpy(lying.data() + 8 + 8 * field, &lie, 8);
      EXPECT_FALSE(size_fits(lying, lying.size()));
      EXPECT_FALSE(decode(lying));
    }
  }
  EXPECT_TRUE(size_fits(std::string_view(bytes).substr(0, kRecordHeaderSize), bytes.size()));
}

}  // namespace
}  // namespace caustic::service
