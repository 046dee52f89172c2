// Photographs that a person leaves out, and keypose-capture.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/testing/capture_program.h"
#include "core/io/pictures/image_set.h"

namespace keypose::capture::left_out_program_test {

using ::testing::HasSubstr;
using ::testing::Not;

class LeftOut : public CaptureProgram {
 protected:
  std::vector<std::string> Captured() const {
    std::vector<std::string> names;
    for (const CapturedImage& image : ReadImageSet(images).images) names.push_back(image.name);
    return names;
  }
};

TEST_F(LeftOut, IsNotReadNorAreItsMaskAndItsClicks) {
  WritePhotos(9);
  WriteFile(photos / "p11.jpg", "no picture at all");
  fs::create_directories(photos / "masks");
  WriteImage(photos / "masks/p11.jpg.png", Image8(180, 120, 1, 255));
  const Outcome outcome = Run("--leave_out 'p11.jpg' --figure 'p11.jpg:90,60'");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(Captured(), ::testing::ElementsAre("p10.jpg", "p12.jpg", "p13.jpg", "p14.jpg",
                                                 "p15.jpg", "p16.jpg", "p17.jpg", "p18.jpg"));
  EXPECT_THAT(outcome.output, HasSubstr("left out, as leave_out says: p11.jpg"));
  EXPECT_THAT(outcome.output, Not(HasSubstr("belong to no photograph")));
  EXPECT_THAT(outcome.output, Not(HasSubstr("click")));
  EXPECT_THAT(Report(), HasSubstr("\"left_out\": [\n   \"p11.jpg\"\n  ]"));
}

TEST_F(LeftOut, TheOthersAreAsIfItWereNotThere) {
  WritePhotos(9);
  ASSERT_EQ(Run("--leave_out p18.jpg").code, 0);
  const std::string with = ReadFile(images / "masks/p10.jpg.png");
  fs::remove(photos / "p18.jpg");
  ASSERT_EQ(Run("--overwrite").code, 0);
  EXPECT_EQ(ReadFile(images / "masks/p10.jpg.png"), with);
}

TEST_F(LeftOut, ANameOfNoneIsTold) {
  WritePhotos(8);
  const Outcome outcome = RunMasked("--leave_out p1l.jpg");
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.output, HasSubstr("leave_out names photographs that are not there: p1l.jpg"));
}

TEST_F(LeftOut, TooManyAreAnError) {
  WritePhotos(8);
  EXPECT_EQ(Run("--leave_out p10.jpg").code, 3);
  fs::create_directories(photos / "lying");
  for (int i = 0; i < 8; ++i) {
    const std::string name = "p" + std::to_string(10 + i) + ".jpg";
    fs::rename(photos / name, photos / "lying" / name);
  }
  const Outcome outcome =
      Run("--leave_out 'lying/p10.jpg; p11.jpg; p12.jpg; p13.jpg; p14.jpg; p15.jpg; p16.jpg; "
          "lying_p17.jpg'");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("are left out; take some back"));
}

}  // namespace keypose::capture::left_out_program_test
