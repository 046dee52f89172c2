#include "capture/shoot/devices/steps_lines.h"

#include <gtest/gtest.h>

namespace keypose::capture::shoot::steps_lines_test {

TEST(StepsLines, HaveTheChecksumOfTheDocumentation) {
  EXPECT_EQ(Crc8("123456789"), 0xF4);  // the check value of CRC-8/SMBUS, the same polynomial
  EXPECT_EQ(FormatStepsLine('>', {1, "HELLO"}), ">1 HELLO*A3");
  const auto line =
      ParseStepsLine('<', "\x01noise<1 OK keypose=1 boot=5 turn=3200 at=0 moving=0*AD");
  ASSERT_TRUE(line);
  EXPECT_EQ(StepsValues(line->text).at("turn"), 3200);
}

TEST(StepsLines, WithAnyByteChangedAreDropped) {
  const std::string good = FormatStepsLine('>', {7, "GO 1600"});
  for (std::size_t i = 1; i < good.size(); ++i)
    for (const char other : {'0', '7', 'A', ' ', '*', '\x7f'}) {
      std::string bad = good;
      bad[i] = other;
      if (bad != good) {
        EXPECT_FALSE(ParseStepsLine('>', bad)) << bad;
      }
    }
  for (const char* text : {"", ">", ">1*", ">256 AT*00", "AT", ">1 HELLO*A", ">1 HELLO*A3B"})
    EXPECT_FALSE(ParseStepsLine('>', text)) << text;
}

}  // namespace keypose::capture::shoot::steps_lines_test
