// keypose-capture as its users run it: masks, groups, options, boards.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "capture/testing/capture_program.h"
#include "capture/testing/test_images.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/pictures/painted_masks.h"
#include "core/io/text/files.h"
#include "core/numbers/sha256.h"
#include "core/testing/paths.h"

namespace keypose::capture::capture_program_test {

using ::testing::HasSubstr;

TEST_F(CaptureProgram, KeepsJpegBytesAndWritesMasksListAndSheet) {
  ExifToWrite exif;
  exif.focal_35mm = 60;
  exif.make = "Maker";
  exif.model = "Model";
  WritePhotos(9, 180, 120, &exif);
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const ImageSet set = ReadImageSet(images);
  ASSERT_EQ(set.images.size(), 9U);
  EXPECT_DOUBLE_EQ(set.images[0].focal_px, 60.0 / 36 * 180);
  EXPECT_EQ(ReadFile(images / "p10.jpg"), ReadFile(photos / "p10.jpg"));
  const Image8 mask = ReadImage(images / "masks/p10.jpg.png", 1),
               truth = MakeTestPhoto(0, 180, 120, TestWall::kDark).truth;
  double both = 0, either = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i)
    both += mask.data[i] && truth.data[i], either += mask.data[i] || truth.data[i];
  EXPECT_GT(both / either, 0.94);
  EXPECT_TRUE(fs::exists(images / "contact_sheet.jpg"));
}

TEST_F(CaptureProgram, TwoRunsGiveTheSameBytes) {
  WritePhotos(8);
  ASSERT_EQ(Run().code, 0);
  const std::string first =
      ReadFile(images / "capture.json") + ReadFile(images / "masks/p12.jpg.png");
  fs::remove_all(images);
  ASSERT_EQ(Run().code, 0);
  EXPECT_EQ(ReadFile(images / "capture.json") + ReadFile(images / "masks/p12.jpg.png"), first);
}

TEST_F(CaptureProgram, MasksOfTheUserWin) {
  WritePhotos(8);
  Image8 mask(180, 120, 1, 0);
  for (int y = 20; y < 60; ++y)
    for (int x = 30; x < 90; ++x) *mask.at(x, y) = 255;
  fs::create_directories(photos / "masks");
  WriteImage(photos / "masks/p13.png", mask);
  ASSERT_EQ(Run().code, 0);
  EXPECT_EQ(ReadImage(images / "masks/p13.jpg.png", 1).data, mask.data);
  EXPECT_NE(ReadImage(images / "masks/p12.jpg.png", 1).data, mask.data);
}

TEST_F(CaptureProgram, CleanPlateBesideThePhotographsIsUsed) {
  WritePhotos(8);
  WriteImage(photos / "background.png", MakeTestWall(180, 120, TestWall::kDark));
  ASSERT_EQ(Run().code, 0);
  EXPECT_EQ(ReadImageSet(images).images.size(), 8U);
  EXPECT_THAT(Report(), HasSubstr("\"clean_plate\": true"));
}

// The figure differs from the wall by a quarter of what it usually does.
TEST_F(CaptureProgram, CleanPlateDifferenceDecidesWhatCountsAsTheSet) {
  const Image8 wall = MakeTestWall(180, 120, TestWall::kDark);
  for (int i = 0; i < 8; ++i) {
    Image8 image = MakeTestPhoto(i, 180, 120, TestWall::kDark).image;
    for (std::size_t k = 0; k < image.data.size(); ++k)
      image.data[k] = static_cast<std::uint8_t>((image.data[k] + 3 * wall.data[k]) / 4);
    WriteImage(photos / ("p" + std::to_string(10 + i) + ".png"), image);
  }
  WriteImage(photos / "background.png", wall);
  const auto covered = [&](const std::string& difference) {
    if (Run("--overwrite --clean_plate_difference " + difference).code != 0) return 0.0;
    double pixels = 0;
    for (int i = 0; i < 8; ++i) {
      const Image8 mask = ReadImage(images / ("masks/p" + std::to_string(10 + i) + ".png.png"), 1);
      pixels += static_cast<double>(std::count(mask.data.begin(), mask.data.end(), 255));
    }
    return pixels;
  };
  EXPECT_LT(covered("50"), covered("6"));
}

TEST_F(CaptureProgram, ShrinksToMaxSize) {
  WritePhotos(8);
  ASSERT_EQ(Run("--max_size 90").code, 0);
  EXPECT_EQ(ReadImageInfo(images / "p10.jpg").width, 90);
  EXPECT_EQ(ReadImageInfo(images / "masks/p10.jpg.png").width, 90);
  const ImageSet set = ReadImageSet(images);
  EXPECT_EQ(set.images[0].photograph_width, 180);
  EXPECT_EQ(set.images[0].photograph_height, 120);
}

TEST_F(CaptureProgram, BlackMasksAreAnInputError) {
  WritePhotos(8);
  fs::create_directories(photos / "masks");
  for (int i = 0; i < 8; ++i)
    WriteImage(photos / ("masks/p" + std::to_string(10 + i) + ".png"), Image8(180, 120, 1, 0));
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("masks of 8 of 8 photographs are black"));
}

TEST_F(CaptureProgram, MaskOfAnotherSizeIsAnInputError) {
  WritePhotos(8);
  fs::create_directories(photos / "masks");
  WriteImage(photos / "masks/p12.png", Image8(90, 90, 1, 255));
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("is 90 x 90, but p12.jpg is 180 x 120"));
}

TEST_F(CaptureProgram, SecondMaskOfAPhotographIsNamedWithTheOneThatIsUsed) {
  WritePhotos(8);
  fs::create_directories(photos / "masks");
  for (const char* name : {"p12.png", "p12_mask.png"})
    WriteImage(photos / "masks" / name, MakeTestPhoto(2, 180, 120, TestWall::kDark).truth);
  ASSERT_EQ(Run().code, 0);
  EXPECT_THAT(Report(), HasSubstr("p12_mask.png (for p12.jpg p12.png is used)"));
}

TEST_F(CaptureProgram, MaskThatWasPaintedOverAnotherPhotographIsNamedAndNotUsed) {
  WritePhotos(8);
  const fs::path photo = photos / "p13.jpg", masks = root / "painted", mask = masks / "p13.jpg.png";
  fs::create_directories(masks);
  for (int i = 0; i < 8; ++i)
    if (i != 3)
      WriteImage(masks / ("p" + std::to_string(10 + i) + ".jpg.png"),
                 MakeTestPhoto(i, 180, 120, TestWall::kDark).truth);
  WriteImage(mask, Image8(180, 120, 1, 255));
  const auto is_used = [&] {
    const Outcome outcome = Run("--masks " + masks.string());
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    const bool warned = outcome.output.find("not used: p13.jpg;") != std::string::npos;
    const bool used = ReadImage(images / "masks/p13.jpg.png", 1).at(2, 2)[0] == 255;
    EXPECT_NE(warned, used) << outcome.output;
    return used;
  };
  WritePaintedMasks(masks,
                    {{"p13.jpg.png", {Sha256Of(ReadFile(mask)), Sha256Of(ReadFile(photo))}}});
  EXPECT_TRUE(is_used());
  WriteImage(photo, MakeTestPhoto(20, 180, 120, TestWall::kDark).image);
  EXPECT_FALSE(is_used());
  EXPECT_THAT(Report(), HasSubstr("masks_of_others"));
  Image8 mended(180, 120, 1, 255);
  mended.data.back() = 0;
  WriteImage(mask, mended);
  EXPECT_TRUE(is_used()) << "another program has painted since";
}

TEST_F(CaptureProgram, PaintedMaskWhosePhotographWasDeletedStopsNothing) {
  WritePhotos(8);
  const fs::path masks = root / "painted";
  fs::create_directories(masks);
  WriteImage(masks / "p30.jpg.png", Image8(180, 120, 1, 255));
  EXPECT_EQ(Run("--masks " + masks.string()).code, 3) << "all masks may be misnamed";
  WritePaintedMasks(masks, {{"p30.jpg.png", {"of the mask", "of the photograph"}}});
  const Outcome outcome = Run("--masks " + masks.string());
  EXPECT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("belong to no photograph were left out: p30.jpg.png"));
}

TEST_F(CaptureProgram, UnknownOptionIsAUsageError) {
  WritePhotos(8);
  EXPECT_EQ(Run("--min_sharpnes 0").code, 2);
}

TEST_F(CaptureProgram, PrintsTheBoardAlone) {
  const fs::path pdf = root / "board.pdf";
  const std::string program = BinFolder() + "/keypose-capture --print-board " + pdf.string();
  EXPECT_EQ(std::system((program + " > /dev/null 2>&1").c_str()), 0);
  EXPECT_EQ(ReadFile(pdf).substr(0, 5), "%PDF-");
  EXPECT_EQ(WEXITSTATUS(std::system((program + " --board_square_mm 60 > /dev/null 2>&1").c_str())),
            2);
}

TEST_F(CaptureProgram, PrintsABoardOfTheAskedSizeAndPaper) {
  const auto board = [&](const std::string& options) {
    const fs::path pdf = root / "board.pdf";
    const std::string command = BinFolder() + "/keypose-capture --print-board " + pdf.string() +
                                " " + options + " > /dev/null 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << options;
    return ReadFile(pdf);
  };
  const std::string plain = board("");
  EXPECT_NE(board("--board_columns 9"), plain);
  EXPECT_NE(board("--board_rows 6"), plain);
  EXPECT_THAT(plain, HasSubstr("841.8"));  // height of A4 in points
  EXPECT_THAT(board("--board_page letter"), HasSubstr("792"));
}

TEST_F(CaptureProgram, SubfoldersAreGroupsWithPrefixedNames) {
  for (const char* group : {"upright", "lying"}) {
    fs::create_directories(photos / group);
    for (int i = 0; i < 4; ++i)
      WriteImage(photos / group / ("p" + std::to_string(i) + ".jpg"),
                 MakeTestPhoto(i + (group[0] == 'l' ? 4 : 0), 180, 120, TestWall::kDark).image, 95);
  }
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const ImageSet set = ReadImageSet(images);
  ASSERT_EQ(set.images.size(), 8u);
  EXPECT_EQ(set.images[0].name, "lying_p0.jpg");
  EXPECT_EQ(set.images[0].group, "lying");
  EXPECT_EQ(set.images[7].name, "upright_p3.jpg");
  EXPECT_EQ(set.images[7].group, "upright");
  EXPECT_THAT(Report(), HasSubstr("\"upright\": 4"));
}

TEST_F(CaptureProgram, NamesThatBeginWithLyingAreAGroupToo) {
  WritePhotos(6);
  for (int i = 0; i < 4; ++i)
    WriteImage(photos / ("LYING_" + std::to_string(i) + ".jpg"),
               MakeTestPhoto(i + 6, 180, 120, TestWall::kDark).image, 95);
  ASSERT_EQ(Run().code, 0);
  const ImageSet set = ReadImageSet(images);
  EXPECT_EQ(set.images[set.Find("LYING_2.jpg")].group, "lying");
  EXPECT_EQ(set.images[set.Find("p10.jpg")].group, "upright");
}

TEST_F(CaptureProgram, PhotographsInTheFolderAndInSubfoldersAreAnInputError) {
  WritePhotos(9);
  fs::create_directories(photos / "lying");
  WriteImage(photos / "lying" / "a.jpg", MakeTestPhoto(1, 180, 120, TestWall::kDark).image, 95);
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("subfolder lying"));
}

}  // namespace keypose::capture::capture_program_test
