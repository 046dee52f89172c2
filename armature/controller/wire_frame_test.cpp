#include "armature/controller/wire_frame.h"

#include <gtest/gtest.h>

#include <random>

namespace keypose::armature::wire_test {

TEST(WireCrc, MeetsItsKnownAnswer) { EXPECT_EQ(WireCrc("123456789"), 0x29B1); }

TEST(WireFrameReader, FindsFramesAmongNoise) {
  const WireFrame a{0x83, 7, std::string("\xA5\x5A\x00", 3)}, b{0x81, 8, ""};
  WireFrameReader reader;
  reader.Push("\xA5\xA5\x5Agarbage" + EncodeFrame(a) + "\xA5");
  std::vector<WireFrame> found;
  while (const auto frame = reader.Next()) found.push_back(*frame);
  reader.Push(EncodeFrame(b).substr(1));  // its first byte came with the last push
  while (const auto frame = reader.Next()) found.push_back(*frame);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].payload, a.payload);
  EXPECT_EQ(found[0].seq, 7);
  EXPECT_EQ(found[1].kind, 0x81);
}

TEST(WireFrameReader, LosesOnlyTheDamagedFrame) {
  std::mt19937 random(3);
  for (int round = 0; round < 200; ++round) {
    std::string bytes;
    for (int i = 0; i < 20; ++i)
      bytes += EncodeFrame({0x82, static_cast<std::uint8_t>(i), std::string(i, 'x')});
    const std::size_t at = random() % bytes.size();
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
    WireFrameReader reader;
    reader.Push(bytes + std::string(4096, ' '));
    int count = 0;
    while (const auto frame = reader.Next()) ++count;
    EXPECT_GE(count, 19) << at;
    EXPECT_LE(count, 19) << at;
  }
}

TEST(PayloadReader, KnowsWhenItIsTooShort) {
  std::string payload;
  PutU16(&payload, 0xBEEF);
  PutI24(&payload, -2);
  PayloadReader reader(payload);
  EXPECT_EQ(reader.U16(), 0xBEEFu);
  EXPECT_EQ(reader.U24(), 0xFFFFFE);
  EXPECT_TRUE(reader.fine() && reader.at_end());
  reader.U8();
  EXPECT_FALSE(reader.fine());
}

}  // namespace keypose::armature::wire_test
