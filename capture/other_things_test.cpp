// keypose-capture where photographs show another thing than the others.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "capture/testing/capture_program.h"
#include "capture/testing/test_images.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/pictures/other_thing_notes.h"
#include "core/io/text/files.h"

namespace keypose::capture::other_things_test {

using ::testing::HasSubstr;
using ::testing::Not;

class OtherThings : public CaptureProgram {
 protected:
  void WriteStranger(const std::string& name, int index = 4) const {
    WriteImage(photos / name, MakeTestStranger(index, 180, 120, TestWall::kDark), 95);
  }
};

TEST_F(OtherThings, StrangerIsLeftOutAndTheOthersMasksAreAsWithoutIt) {
  WritePhotos(9);
  ASSERT_EQ(Run().code, 0);
  const std::string before =
      ReadFile(images / "capture.json") + ReadFile(images / "masks/p14.jpg.png");
  EXPECT_TRUE(ReadOtherThingNotes(images).empty());
  EXPECT_THAT(Report(), HasSubstr("\"other_things\": []"));
  WriteStranger("p135.jpg");
  const Outcome outcome = Run("--overwrite");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("show another thing than the others, or the set without "
                                        "the figure: p135.jpg; they were left out"));
  EXPECT_THAT(outcome.output, Not(HasSubstr("blurred")));
  EXPECT_EQ(ReadFile(images / "capture.json") + ReadFile(images / "masks/p14.jpg.png"), before);
  EXPECT_FALSE(fs::exists(images / "p135.jpg"));
  EXPECT_EQ(ReadOtherThingNotes(images).count("p135.jpg"), 1U);
}

TEST_F(OtherThings, TheSetWithoutTheFigureIsLeftOut) {
  WritePhotos(9);
  WriteImage(photos / "a.jpg", MakeTestWall(180, 120, TestWall::kDark), 95);
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_EQ(ReadOtherThingNotes(images).count("a.jpg"), 1U) << outcome.output;
}

TEST_F(OtherThings, StrangerIsKeptWhereAPersonSaysSo) {
  WritePhotos(9);
  WriteStranger("p135.jpg");
  const Outcome asked = Run("--other_things keep");
  EXPECT_EQ(asked.code, 0) << asked.output;
  EXPECT_THAT(asked.output, HasSubstr("they were kept"));
  EXPECT_EQ(ReadImageSet(images).images.size(), 10U);
  fs::create_directories(photos / "masks");
  WriteImage(photos / "masks/p135.png", MakeTestPhoto(4, 180, 120, TestWall::kDark).truth);
  const Outcome masked = Run("--overwrite");
  EXPECT_EQ(masked.code, 0) << masked.output;
  EXPECT_EQ(ReadImageSet(images).images.size(), 10U);
  EXPECT_TRUE(ReadOtherThingNotes(images).empty());
}

TEST_F(OtherThings, MixedRingsAreAnInputErrorThatNamesBoth) {
  WritePhotos(8);
  for (int i = 0; i < 5; ++i) WriteStranger("q" + std::to_string(i) + ".jpg", i);
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("2 different things: 8 show one: p10.jpg"));
  EXPECT_THAT(outcome.output, HasSubstr("5 show one: q0.jpg, q1.jpg, q2.jpg, q3.jpg, q4.jpg"));
  EXPECT_EQ(Run("--other_things keep").code, 0);
}

TEST_F(OtherThings, FewerThanAskedForAreLeft) {
  WritePhotos(7);
  WriteStranger("q.jpg");
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("only 7 photographs show one thing"));
}

TEST_F(OtherThings, PhotographThatWasSavedAgainIsNamedWithItsOriginal) {
  WritePhotos(10);
  EXPECT_EQ(Run().code, 0);
  EXPECT_THAT(Report(), Not(HasSubstr("same_views")));
  WriteImage(photos / "z.jpg", MakeTestPhoto(3, 180, 120, TestWall::kDark).image, 80);
  const Outcome outcome = Run("--overwrite");
  EXPECT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("same view twice: z.jpg = p13.jpg"));
}

}  // namespace keypose::capture::other_things_test
