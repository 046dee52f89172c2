// Clean plates of RAW sessions and of sessions with a grey card; RAW files beside their JPEGs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>

#include "capture/shoot/record/side_file.h"
#include "capture/testing/capture_program.h"
#include "core/io/pictures/image_set.h"
#include "core/pictures/srgb.h"
#include "core/testing/dng.h"

namespace keypose::capture::plates_and_pairs_test {

using ::testing::HasSubstr;
using ::testing::Not;

/// Share of the figure's pixels, in the mask or the truth, that are in both.
double SharedPart(const Image8& mask, const Image8& truth) {
  double both = 0, either = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i)
    both += mask.data[i] && truth.data[i], either += mask.data[i] || truth.data[i];
  return both / either;
}

ImageF LightOf(const Image8& image) {
  ImageF linear(image.width, image.height, image.channels);
  for (std::size_t i = 0; i < image.data.size(); ++i)
    linear.data[i] = static_cast<float>(LinearFromSrgb(image.data[i] / 255.0));
  return linear;
}

TEST_F(CaptureProgram, TheCleanPlateHasTheWhiteBalanceOfItsPhotographs) {
  for (int i = 0; i < 8; ++i) {
    char name[16];
    std::snprintf(name, sizeof name, "r1_a%03d.jpg", 45 * i);
    WriteImage(photos / name, MakeTestPhoto(i, 180, 120, TestWall::kLight).image, 95);
  }
  WriteImage(photos / "background.png", MakeTestWall(180, 120, TestWall::kLight));
  shoot::SideFile side;
  side.pose = "rest";
  side.plan = {.rings_deg = {12.5}, .angles = 8};
  side.white = shoot::CarriedWhite{{0.7, 1, 1.3}, "card.jpg"};
  WriteFile(photos / "shoot.json", shoot::SideFileText(side));
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_GT(SharedPart(ReadImage(images / "masks/r1_a000.jpg.png", 1),
                       MakeTestPhoto(0, 180, 120, TestWall::kLight).truth),
            0.9);
}

TEST_F(CaptureProgram, ARawCleanPlateOfRawPhotographsIsUsed) {
  const auto write = [&](const std::string& name, const Image8& image) {
    WriteDng(photos / name, LightOf(image), {.neutral = {0.6, 1, 0.8}});
  };
  for (int i = 0; i < 8; ++i)
    write("p" + std::to_string(i) + ".DNG", MakeTestPhoto(i, 180, 120, TestWall::kDark).image);
  write("Background.DNG", MakeTestWall(180, 120, TestWall::kDark));
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(Report(), HasSubstr("\"clean_plate\": true"));
  EXPECT_THAT(Report(), Not(HasSubstr("no photographs")));
  EXPECT_EQ(ReadImageSet(images).images.size(), 8U);
}

TEST_F(CaptureProgram, RawFilesInAFolderOfTheirOwnAreNoOtherPlacement) {
  fs::create_directories(photos / "jpeg");
  fs::create_directories(photos / "raw");
  for (int i = 0; i < 8; ++i) {
    const std::string name = "p" + std::to_string(i);
    WriteImage(photos / "jpeg" / (name + ".jpg"), MakeTestPhoto(i, 180, 120, TestWall::kDark).image,
               95);
    WriteFile(photos / "raw" / (name + ".CR2"), "x");
  }
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_EQ(ReadImageSet(images).images.size(), 8U);
  EXPECT_THAT(outcome.output, HasSubstr("8 .cr2"));
}

}  // namespace keypose::capture::plates_and_pairs_test
