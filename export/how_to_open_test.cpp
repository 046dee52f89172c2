// The words beside the files.
#include "export/how_to_open.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace keypose::exporting::how_to_open_test {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(HowToOpen, SaysOfEachFormatAskedForWhatToDo) {
  const std::string text = HowToOpen({"glb", "usda"}, 24);
  EXPECT_THAT(text, HasSubstr("\ncharacter.glb\n"));
  EXPECT_THAT(text, HasSubstr("set Shading to Smooth"));
  EXPECT_THAT(text, HasSubstr("no attribute 'bool'"));
  EXPECT_THAT(text, HasSubstr("three.js shows its first picture, still"));
  EXPECT_THAT(text, Not(HasSubstr("cache/")));
}

TEST(HowToOpen, FillsInTheRate) {
  const std::string text = HowToOpen({"pc2", "mdd"}, 12.5);
  EXPECT_THAT(text, HasSubstr("Set the frame rate to 12.5."));
  EXPECT_THAT(text, HasSubstr("with cache/character.mdd, Format MDD;"));
  EXPECT_THAT(text, Not(HasSubstr("{")));
}

}  // namespace keypose::exporting::how_to_open_test
