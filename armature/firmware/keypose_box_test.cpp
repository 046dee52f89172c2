#include "armature/firmware/keypose_box.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "armature/firmware/testing/box_bench.h"

namespace keypose::armature::keypose_box_test {

TEST(Box, AnswersAreRefusalsWhereARequestIsOfAWrongForm) {
  DirectLine line(4);
  const auto reply_to = [&](const WireFrame& request) {
    line.Write(EncodeFrame(request));
    WireFrameReader reader;
    reader.Push(line.Read(0));
    return reader.Next();
  };
  for (const auto& [kind, payload] : std::map<int, std::string>{
           {0x01, "x"}, {0x02, "x"}, {0x03, "xxx"}, {0x04, "x"}, {0x05, "\x02"}, {0x06, "x"}}) {
    const auto reply = reply_to({static_cast<std::uint8_t>(kind), 1, payload});
    ASSERT_TRUE(reply) << kind;
    EXPECT_EQ(reply->kind, 0xFF) << kind;
    EXPECT_EQ(reply->payload, "\x02") << kind;
  }
  EXPECT_EQ(reply_to({0x33, 1, ""})->payload, "\x01");
}

TEST(Box, AnyBytesLeaveItWhole) {
  DirectLine line(74);
  std::mt19937 random(9);
  for (int i = 0; i < 300000; ++i)
    line.box->Take(static_cast<std::uint8_t>(random() % 7 ? random() : 0xA5));
  line.bench.sent.clear();
  BoxLink link(line);
  EXPECT_EQ(link.Greet().sensors, 74);
}

}  // namespace keypose::armature::keypose_box_test
