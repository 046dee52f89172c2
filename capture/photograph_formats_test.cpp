// keypose-capture on JPEG, HEIC, PNG, TIFF and RAW, and on the photographs of a session.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include "capture/shoot/develop/white_balance.h"
#include "capture/shoot/record/side_file.h"
#include "capture/testing/capture_program.h"
#include "capture/testing/test_images.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/io/pictures/image_set.h"
#include "core/io/text/files.h"
#include "core/pictures/image_turns.h"
#include "core/pictures/srgb.h"
#include "core/testing/dng.h"
#include "core/values/exif_focal.h"

namespace keypose::capture::photograph_formats_test {

using ::testing::HasSubstr;

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

/// A test photograph with 16 bits: each level moved by up to half a step of 8.
Image16 DeepPhoto(int index) {
  const Image8 eight = MakeTestPhoto(index, 180, 120, TestWall::kDark).image;
  Image16 deep(180, 120, 3);
  for (std::size_t i = 0; i < deep.data.size(); ++i)
    deep.data[i] = static_cast<std::uint16_t>(
        std::clamp<int>(257 * eight.data[i] + static_cast<int>(i % 257) - 128, 0, 65535));
  return deep;
}

TEST_F(CaptureProgram, SixteenBitsStayWhereAPhotographIsTurnedOrMadeSmaller) {
  WritePhotos(6);
  ExifToWrite turned;
  turned.orientation = 3;
  WriteImage(photos / "q.tif", DeepPhoto(6), 92, &turned);
  WriteImage(photos / "r.png", DeepPhoto(7));
  ASSERT_EQ(RunMasked().code, 0);
  EXPECT_EQ(ReadFile(images / "r.png"), ReadFile(photos / "r.png"));
  const Image16 upright = ReadAsStored(images / "q.tif").sixteen;
  EXPECT_EQ(upright.data, Oriented(DeepPhoto(6), 3).data);
  EXPECT_EQ(ReadImageInfo(images / "q.tif").orientation, 1);
  ASSERT_EQ(RunMasked("--max_size 90").code, 0);
  const Image16 half = ReadAsStored(images / "r.png").sixteen, whole = DeepPhoto(7);
  ASSERT_EQ(half.width, 90);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(
        half.at(20, 30)[c],
        (whole.at(40, 60)[c] + whole.at(41, 60)[c] + whole.at(40, 61)[c] + whole.at(41, 61)[c]) /
            4.0,
        0.51);
  EXPECT_EQ(ReadAsStored(images / "q.tif").sixteen.width, 90);
}

TEST_F(CaptureProgram, ATurnedPhotographOf16BitsIsLookedAtAsItsUprightTwin) {
  WritePhotos(6);
  ExifToWrite turned;
  turned.orientation = 3;
  WriteImage(photos / "q.tif", DeepPhoto(6), 92, &turned);  // written anew
  WriteImage(photos / "r.png", Oriented(DeepPhoto(6), 3));  // copied, read as 8 bits
  ASSERT_EQ(Run().code, 0);
  const ImageSet set = ReadImageSet(images);
  ASSERT_EQ(set.images.size(), 8U);
  const CapturedImage &anew = set.images[6], &copied = set.images[7];
  ASSERT_EQ(anew.name, "q.tif");
  EXPECT_GT(anew.sharpness, 0);
  EXPECT_EQ(anew.sharpness, copied.sharpness);
  EXPECT_EQ(anew.exposure, copied.exposure);
  EXPECT_EQ(anew.mask_fraction, copied.mask_fraction);
  EXPECT_EQ(ReadImage(images / "q.tif", 3).data, ReadImage(images / "r.png", 3).data);
  EXPECT_EQ(ReadFile(images / "masks/q.tif.png"), ReadFile(images / "masks/r.png.png"));
}

TEST_F(CaptureProgram, HeicBecomesJpegWithItsFocalLength) {
  ExifToWrite exif;
  exif.focal_35mm = 26;
  exif.make = "Apple";
  exif.model = "iPhone 12";
  for (int i = 0; i < 8; ++i)
    // a width that the image library's HEIC writer can take
    WriteImage(photos / ("IMG_" + std::to_string(i) + ".HEIC"),
               MakeTestPhoto(i, 192, 120, TestWall::kDark).image, 95, &exif);
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const ImageSet set = ReadImageSet(images);
  ASSERT_EQ(set.images.size(), 8U);
  EXPECT_EQ(set.images[0].name, "IMG_0.jpg");
  EXPECT_DOUBLE_EQ(set.images[0].focal_px, 26 / kFilmDiagonal_mm * std::hypot(192, 120));
  const ImageInfo info = ReadImageInfo(images / "IMG_0.jpg");
  EXPECT_EQ(info.format, "jpeg");
  EXPECT_DOUBLE_EQ(info.focal_35mm.value_or(0), 26);
  EXPECT_TRUE(fs::exists(images / "masks/IMG_0.jpg.png"));
}

TEST_F(CaptureProgram, JfifIsWrittenAsTheJpegThatItIs) {
  WritePhotos(8);
  for (const char* name : {"p12", "p14"})
    fs::rename(photos / (std::string(name) + ".jpg"), photos / (std::string(name) + ".JFIF"));
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_EQ(ReadImageSet(images).images[2].name, "p12.jpg");
  EXPECT_EQ(ReadFile(images / "p12.jpg"), ReadFile(photos / "p12.JFIF"));
}

TEST_F(CaptureProgram, PhotographAsHeicAndAsJpegIsAnInputError) {
  WritePhotos(8);
  WriteImage(photos / "p12.heic", MakeTestPhoto(2, 192, 120, TestWall::kDark).image);
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("p12.jpg is there twice, as HEIC and as JPEG"));
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
  ASSERT_EQ(RunMasked().code, 0);
  EXPECT_THAT(Report(), ::testing::Not(HasSubstr("no photographs")));
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
  ASSERT_EQ(RunMasked().code, 0);
  EXPECT_THAT(Report(), ::testing::Not(HasSubstr("no photographs")));
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
  ASSERT_EQ(RunMasked().code, 0);
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

}  // namespace keypose::capture::photograph_formats_test
