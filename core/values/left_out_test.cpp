#include "core/values/left_out.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace keypose::left_out_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(LeftOut, NamesStandBetweenSemicolons) {
  EXPECT_THAT(ParseLeftOut("a b.jpg; lying/c.jpg ;a b.jpg;;"),
              ElementsAre("a b.jpg", "lying/c.jpg"));
  EXPECT_EQ(LeftOutText({"a b.jpg", "lying/c.jpg"}), "a b.jpg; lying/c.jpg");
  EXPECT_THAT(ParseLeftOut(" "), IsEmpty());
  EXPECT_EQ(LeftOutText({}), "");
}

TEST(LeftOut, AnyNameComesBackAsItWas) {
  const std::vector<std::string> names = {"a;b.jpg", " 100%.jpg ", "%3B.jpg", "Füße\n.jpg", "%"};
  EXPECT_EQ(LeftOutText({"a;b.jpg", " x"}), "a%3Bb.jpg; %20x");
  EXPECT_EQ(ParseLeftOut(LeftOutText(names)), names);
}

TEST(LeftOut, APhotographIsMeantByItsPathItsNameOrAsItIsWritten) {
  for (const char* name : {"lying/a.heic", "a.heic", "lying_a.jpg"})
    EXPECT_TRUE(MeansPhotograph(name, "lying/a.heic", "lying_a.jpg")) << name;
  EXPECT_FALSE(MeansPhotograph("a.jpg", "lying/a.heic", "lying_a.jpg"));
}

}  // namespace keypose::left_out_test
