// keypose-capture as its users run it: exit codes, messages, files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "capture/shoot/develop/white_balance.h"
#include "capture/shoot/record/side_file.h"
#include "capture/testing/test_images.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/io/testing_dng.h"
#include "core/srgb.h"

namespace keypose::capture {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

struct Outcome {
  int code = -1;
  std::string output;
};

class CaptureProgram : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "capture_test_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    root = pattern;
    photos = root / "photos";
    images = root / "images";
    fs::create_directories(photos);
  }
  void TearDown() override { fs::remove_all(root); }

  void WritePhotos(int count, int width = 180, int height = 120,
                   const ExifToWrite* exif = nullptr) {
    for (int i = 0; i < count; ++i)
      WriteImage(photos / ("p" + std::to_string(10 + i) + ".jpg"),
                 MakeTestPhoto(i, width, height, TestWall::kDark).image, 95, exif);
  }

  /// @param first  shell commands to run before, such as limits
  Outcome Run(const std::string& more = "", const std::string& first = "") const {
    const fs::path log = root / "log.txt";
    const std::string command = first + KEYPOSE_BIN_DIR + "/keypose-capture --photos " +
                                photos.string() + " --images " + images.string() + " --report " +
                                (root / "report.json").string() + " " + more + " > " +
                                log.string() + " 2>&1";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadFile(log)};
  }
  std::string Report() const { return ReadFile(root / "report.json"); }

  fs::path root, photos, images;
};

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

TEST_F(CaptureProgram, PhotographsWithoutExifAreAccepted) {
  WritePhotos(8);
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("no focal length"));
  EXPECT_THAT(Report(), HasSubstr("\"focal_known\": false"));
}

TEST_F(CaptureProgram, ReadsPngAndTiffAndTurnsPortraits) {
  WritePhotos(6);
  WriteImage(photos / "q.png", MakeTestPhoto(6, 180, 120, TestWall::kDark).image);
  WriteImage(photos / "r.tif", MakeTestPhoto(7, 180, 120, TestWall::kDark).image);
  WriteImage(photos / "s.jpg", MakeTestPhoto(8, 120, 180, TestWall::kDark).image);
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const ImageSet set = ReadImageSet(images);
  ASSERT_EQ(set.images.size(), 9U);
  for (const CapturedImage& image : set.images) EXPECT_EQ(image.width, 180) << image.name;
  EXPECT_EQ(ReadImageInfo(images / "s.jpg").height, 120);
}

TEST_F(CaptureProgram, HeicBecomesJpegWithItsFocalLength) {
  ExifToWrite exif;
  exif.focal_35mm = 26;
  exif.make = "Apple";
  exif.model = "iPhone 12";
  for (int i = 0; i < 8; ++i)
    // 192: the image library's HEIC writer reads beyond rows whose number of bytes is no multiple
    // of 16.
    WriteImage(photos / ("IMG_" + std::to_string(i) + ".HEIC"),
               MakeTestPhoto(i, 192, 120, TestWall::kDark).image, 95, &exif);
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const ImageSet set = ReadImageSet(images);
  ASSERT_EQ(set.images.size(), 8U);
  EXPECT_EQ(set.images[0].name, "IMG_0.jpg");
  EXPECT_DOUBLE_EQ(set.images[0].focal_px, 26.0 / 36 * 192);
  const ImageInfo info = ReadImageInfo(images / "IMG_0.jpg");
  EXPECT_EQ(info.format, "jpeg");
  EXPECT_DOUBLE_EQ(info.focal_35mm.value_or(0), 26);
  EXPECT_TRUE(fs::exists(images / "masks/IMG_0.jpg.png"));
}

TEST_F(CaptureProgram, PhotographAsHeicAndAsJpegIsAnInputError) {
  WritePhotos(8);
  WriteImage(photos / "p12.heic", MakeTestPhoto(2, 192, 120, TestWall::kDark).image);
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("p12.jpg is there twice, as HEIC and as JPEG"));
}

TEST_F(CaptureProgram, FilesThatAreNoPhotographsAreNamedInAWarning) {
  WritePhotos(8);
  for (const char* name :
       {"p10.mov", "p11.mov", "p12.mov", "p10.AAE", "notes.txt", ".hidden", "Thumbs.db"})
    WriteFile(photos / name, "x");
  fs::create_directories(photos / "raw");
  WriteFile(photos / "raw/p10.cr2", "x");
  ASSERT_EQ(Run().code, 0);
  EXPECT_THAT(Report(), HasSubstr("files in photos that are no photographs were left out: 1 .aae "
                                  "(p10.AAE), 1 .cr2 (p10.cr2), "
                                  "3 .mov (p10.mov, p11.mov ...), 1 .txt (notes.txt)"));
}

TEST_F(CaptureProgram, OrdinaryFolderGivesNoWarningOfFiles) {
  WritePhotos(8);
  ASSERT_EQ(Run().code, 0);
  EXPECT_THAT(Report(), testing::Not(HasSubstr("no photographs")));
}

TEST_F(CaptureProgram, FolderOfRawFilesSaysWhatCanBeRead) {
  for (const char* name : {"a.X3F", "b.X3F"}) WriteFile(photos / name, "x");
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr(".heic"));
  EXPECT_THAT(outcome.output, HasSubstr("2 .x3f (a.X3F, b.X3F); develop RAW files to JPEG"));
}

TEST_F(CaptureProgram, DamagedRawFileIsNamed) {
  WriteFile(photos / "a.NEF", "x");
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("a.NEF cannot be developed"));
}

/// The photographs' linear light as a camera's RAW files.
ImageF LinearOf(const Image8& image) {
  ImageF linear(image.width, image.height, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i)
    linear.data[i] = static_cast<float>(LinearFromSrgb(image.data[i] / 255.0));
  return linear;
}

double MeanDifference(const Image8& a, const Image8& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) sum += std::abs(a.data[i] - b.data[i]);
  return sum / static_cast<double>(a.data.size());
}

TEST_F(CaptureProgram, RawFilesAreDeveloped) {
  for (int i = 0; i < 8; ++i)
    WriteDng(photos / ("p" + std::to_string(i) + ".DNG"),
             LinearOf(MakeTestPhoto(i, 180, 120, TestWall::kDark).image),
             {.neutral = {0.6, 1, 0.8}});
  ASSERT_EQ(Run().code, 0);
  const ImageSet set = ReadImageSet(images);
  ASSERT_EQ(set.images.size(), 8u);
  EXPECT_EQ(set.images[3].name, "p3.jpg");
  // Demosaicing softens the speckles.
  const Image8 truth = MakeTestPhoto(3, 180, 120, TestWall::kDark).image;
  EXPECT_LT(MeanDifference(ReadImage(set.ImagePath(3), 3), truth), 8);
}

TEST_F(CaptureProgram, OfARawAndJpegPairTakesTheJpegSilently) {
  WritePhotos(8);
  for (int i = 0; i < 8; ++i) WriteFile(photos / ("p" + std::to_string(10 + i) + ".CR2"), "x");
  ASSERT_EQ(Run().code, 0);
  EXPECT_THAT(Report(), testing::Not(HasSubstr("no photographs")));
  EXPECT_EQ(ReadImageSet(images).images.size(), 8u);
}

/// A session's side file: 8 angles, as `keypose shoot` writes it.
std::string SideFileOf8(bool with_white) {
  shoot::SideFile side;
  side.pose = "rest";
  side.plan = {.rings_deg = {12.5}, .angles = 8};
  if (with_white) side.white = shoot::CarriedWhite{{0.7, 1, 1.3}, "card.jpg"};
  return shoot::SideFileText(side);
}

TEST_F(CaptureProgram, PhotographsOfASessionKeepTheirAngleTiltAndFlip) {
  for (int i = 0; i < 8; ++i) {
    char name[16];
    std::snprintf(name, sizeof name, "r1_a%03d.jpg", 45 * i);
    WriteImage(photos / name, MakeTestPhoto(i, 180, 120, TestWall::kDark).image, 95);
  }
  WriteFile(photos / "shoot.json", SideFileOf8(false));
  fs::create_directories(photos / "stacks");
  WriteFile(photos / "stacks/r1_a045_f1.jpg", "never read");
  ASSERT_EQ(Run().code, 0);
  EXPECT_THAT(Report(), testing::Not(HasSubstr("no photographs")));
  const ImageSet set = ReadImageSet(images);
  ASSERT_EQ(set.images.size(), 8u);
  ASSERT_TRUE(set.images[3].place);
  EXPECT_EQ(set.images[3].place->angle_deg, 135);
  EXPECT_EQ(set.images[3].place->tilt_deg, 12.5);
  EXPECT_EQ(set.images[3].place->ring, 1);
  EXPECT_EQ(set.images[3].place->flip, 0);
  EXPECT_EQ(ReadFile(images / "r1_a135.jpg"), ReadFile(photos / "r1_a135.jpg"));
}

TEST_F(CaptureProgram, AppliesTheWhiteBalanceOfTheSession) {
  for (int i = 0; i < 8; ++i) {
    char name[16];
    std::snprintf(name, sizeof name, "r1_a%03d.jpg", 45 * i);
    WriteImage(photos / name, MakeTestPhoto(i, 180, 120, TestWall::kDark).image, 95);
  }
  WriteFile(photos / "shoot.json", SideFileOf8(true));
  ASSERT_EQ(Run().code, 0);
  const Image8 was = ReadImage(photos / "r1_a000.jpg", 3),
               is = ReadImage(images / "r1_a000.jpg", 3);
  EXPECT_LT(MeanDifference(is, shoot::WithGains(was, {0.7, 1, 1.3})), 2);  // JPEG once more
  EXPECT_GT(MeanDifference(is, was), 5);
}

TEST_F(CaptureProgram, DamagedSideFileIsNamed) {
  WritePhotos(8);
  WriteFile(photos / "shoot.json", "{");
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("shoot.json is damaged"));
}

TEST_F(CaptureProgram, AppliesExifOrientationToPixels) {
  ExifToWrite exif;
  exif.orientation = 6;
  WritePhotos(8, 180, 120, &exif);
  ASSERT_EQ(Run().code, 0);
  const ImageInfo info = ReadImageInfo(images / "p10.jpg");
  EXPECT_EQ(info.orientation, 1);
  EXPECT_EQ(info.width, 120);
  EXPECT_EQ(info.height, 180);
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
}

TEST_F(CaptureProgram, EmptyFolderIsAnInputError) {
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("has no photographs"));
  EXPECT_FALSE(fs::exists(images));
}

TEST_F(CaptureProgram, TwoSizesAreAnInputErrorThatNamesThem) {
  WritePhotos(8);
  WriteImage(photos / "other.jpg", MakeTestPhoto(0, 200, 120, TestWall::kDark).image);
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("other.jpg"));
}

TEST_F(CaptureProgram, TruncatedJpegsAreAllNamed) {
  WritePhotos(9);
  for (const char* name : {"p11.jpg", "p15.jpg"}) {
    const std::string bytes = ReadFile(photos / name);
    WriteFile(photos / name, bytes.substr(0, bytes.size() / 2));
  }
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("p11.jpg"));
  EXPECT_THAT(outcome.output, HasSubstr("p15.jpg"));
  EXPECT_FALSE(fs::exists(images));
}

TEST_F(CaptureProgram, PhotographsOfOddSizesAreNamed) {
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(1, 20000), std::pair(30, 700)}) {
    WritePhotos(8);
    WriteImage(photos / "odd.png", Image8(width, height, 3, 128));
    const Outcome outcome = Run();
    EXPECT_EQ(outcome.code, 3) << outcome.output;
    EXPECT_THAT(outcome.output, HasSubstr("odd.png (" + std::to_string(width) + " x " +
                                          std::to_string(height) + ")"));
    EXPECT_FALSE(fs::exists(images));
  }
}

TEST_F(CaptureProgram, PhotographBeyondTheMemoryIsNamedBeforeItIsRead) {
#if defined(KEYPOSE_SANITIZED)
  GTEST_SKIP() << "a sanitizer's shadow needs all of the address space";
#endif
  WritePhotos(8);
  WriteImage(photos / "giant.jpg", Image8(8000, 6000, 3, 128));
  const Outcome outcome = Run("", "ulimit -v 3000000; ");  // 3 GB, of the 4.3 that it needs
  EXPECT_EQ(outcome.code, 4) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("giant.jpg (8000 x 6000 pixels) needs 4.3 GB"));
}

TEST_F(CaptureProgram, NamesThatAreNotUtf8AreAnInputErrorThatShowsThem) {
  WritePhotos(8);
  fs::copy_file(photos / "p10.jpg", photos / "T\xf6pf.jpg");
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("T\\xf6pf.jpg"));
}

TEST_F(CaptureProgram, LinksToFoldersAboveAndToDevicesAreLeftOut) {
  WritePhotos(8);
  fs::create_directories(photos / "notes");
  for (const char* name : {"a", "b", "c"}) fs::create_symlink(".", photos / "notes" / name);
  fs::create_symlink("/dev/zero", photos / "zero.jpg");
  const Outcome outcome = Run("", "ulimit -t 60; ");
  EXPECT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_FALSE(fs::exists(images / "zero.jpg"));
}

TEST_F(CaptureProgram, FilesThatAreNoImagesAreNamed) {
  WritePhotos(8);
  WriteFile(photos / "text.jpg", "not a photograph");
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("text.jpg"));
}

TEST_F(CaptureProgram, FewPhotographsAreToldOfBeforeCamerasAreSought) {
  WritePhotos(9);
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(Report(), HasSubstr("there are only 9 photographs"));
}

TEST_F(CaptureProgram, CopiesAreAnInputError) {
  WritePhotos(8);
  fs::copy_file(photos / "p12.jpg", photos / "p99.jpg");
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("p99.jpg = p12.jpg"));
}

TEST_F(CaptureProgram, BlurredSetIsAnInputErrorThatNamesThem) {
  for (int i = 0; i < 8; ++i) {
    const TestPhoto photo = MakeTestPhoto(i, 360, 240, TestWall::kDark);
    WriteImage(photos / ("p" + std::to_string(i) + ".jpg"),
               i < 4 ? photo.image : Blurred(photo.image, 4));
  }
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output,
              HasSubstr("4 of 8 photographs are blurred: p4.jpg, p5.jpg, p6.jpg, p7.jpg"));
  EXPECT_FALSE(fs::exists(images));
}

TEST_F(CaptureProgram, BlurredSetIsAcceptedWhereTheLimitsAllowIt) {
  for (int i = 0; i < 8; ++i) {
    const TestPhoto photo = MakeTestPhoto(i, 360, 240, TestWall::kDark);
    WriteImage(photos / ("p" + std::to_string(i) + ".jpg"),
               i < 4 ? photo.image : Blurred(photo.image, 4));
  }
  EXPECT_EQ(Run("--min_sharpness 0").code, 0);
  EXPECT_EQ(Run("--overwrite --max_bad_share 0.5").code, 0);
  EXPECT_THAT(Report(), HasSubstr("blurred"));
  EXPECT_EQ(Run("--overwrite --max_bad_share 0.4").code, 3);
}

TEST_F(CaptureProgram, SmallSetIsAnInputErrorWhereMoreAreAskedFor) {
  WritePhotos(8);
  EXPECT_EQ(Run("--min_images 9").code, 3);
  EXPECT_FALSE(fs::exists(images));
  EXPECT_EQ(Run("--min_images 8").code, 0);
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
  WriteImage(photos / "masks/p12.png", Image8(90, 60, 1, 255));
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("is 90 x 60, but p12.jpg is 180 x 120"));
}

TEST_F(CaptureProgram, SecondMaskOfAPhotographIsNamedWithTheOneThatIsUsed) {
  WritePhotos(8);
  fs::create_directories(photos / "masks");
  for (const char* name : {"p12.png", "p12_mask.png"})
    WriteImage(photos / "masks" / name, MakeTestPhoto(2, 180, 120, TestWall::kDark).truth);
  ASSERT_EQ(Run().code, 0);
  EXPECT_THAT(Report(), HasSubstr("p12_mask.png (for p12.jpg p12.png is used)"));
}

TEST_F(CaptureProgram, UnknownOptionIsAUsageError) {
  WritePhotos(8);
  EXPECT_EQ(Run("--min_sharpnes 0").code, 2);
}

TEST_F(CaptureProgram, PrintsTheBoardAlone) {
  const fs::path pdf = root / "board.pdf";
  const std::string program =
      std::string(KEYPOSE_BIN_DIR) + "/keypose-capture --print-board " + pdf.string();
  EXPECT_EQ(std::system((program + " > /dev/null 2>&1").c_str()), 0);
  EXPECT_EQ(ReadFile(pdf).substr(0, 5), "%PDF-");
  EXPECT_EQ(WEXITSTATUS(std::system((program + " --board_square_mm 60 > /dev/null 2>&1").c_str())),
            2);
}

TEST_F(CaptureProgram, PrintsABoardOfTheAskedSizeAndPaper) {
  const auto board = [&](const std::string& options) {
    const fs::path pdf = root / "board.pdf";
    const std::string command = std::string(KEYPOSE_BIN_DIR) + "/keypose-capture --print-board " +
                                pdf.string() + " " + options + " > /dev/null 2>&1";
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

}  // namespace
}  // namespace keypose::capture
