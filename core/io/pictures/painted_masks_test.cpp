#include "core/io/pictures/painted_masks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::painted_masks_test {

class PaintedMasksFile : public ::testing::Test, public TestingFolder {};

TEST_F(PaintedMasksFile, IsReadAsItWasWrittenAndGoesWithTheLastMask) {
  const PaintedMasks masks = {{"a.jpg.png", {"m1", "p1"}}, {"b.jpg.png", {"m2", "p2"}}};
  WritePaintedMasks(folder_, masks);
  const std::string text = ReadFile(folder_ / kPaintedNotes);
  EXPECT_EQ(ReadPaintedMasks(folder_), masks);
  WritePaintedMasks(folder_, masks);
  EXPECT_EQ(ReadFile(folder_ / kPaintedNotes), text) << "else capture would run again";
  WritePaintedMasks(folder_, {});
  EXPECT_FALSE(fs::exists(folder_ / kPaintedNotes));
  EXPECT_TRUE(ReadPaintedMasks(folder_).empty());
}

TEST(PaintedMasks, OnlyAMaskThatIsAsItWasPaintedIsKnownToBeOfAnotherPhotograph) {
  const PaintedMasks masks = {{"a.jpg.png", {"mask", "photograph"}}};
  EXPECT_TRUE(IsOfAnother(masks, "a.jpg.png", {"mask", "shot again"}));
  EXPECT_FALSE(IsOfAnother(masks, "a.jpg.png", {"mask", "photograph"}));
  EXPECT_FALSE(IsOfAnother(masks, "a.jpg.png", {"changed elsewhere", "shot again"}));
  EXPECT_FALSE(IsOfAnother(masks, "b.jpg.png", {"mask", "shot again"}));
}

TEST_F(PaintedMasksFile, DamageIsAnInputErrorThatSaysWhatToDo) {
  for (const char* text :
       {"{", "7", "{}", R"({"masks": {"a.png": {"mask": 3}}})", R"({"masks": 1})"}) {
    Put(kPaintedNotes, text);
    try {
      ReadPaintedMasks(folder_);
      ADD_FAILURE() << text << " was read";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("painted.json is damaged")) << text;
      EXPECT_THAT(error.what(), ::testing::HasSubstr("delete it")) << text;
    }
  }
}

}  // namespace keypose::painted_masks_test
