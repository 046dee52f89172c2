// keypose-capture on photographs that it must refuse, leave out or warn of.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <utility>

#include "capture/testing/capture_program.h"
#include "capture/testing/test_images.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"

namespace keypose::capture::photograph_faults_test {

using ::testing::HasSubstr;

TEST_F(CaptureProgram, FilesThatAreNoPhotographsAreNamedInAWarning) {
  WritePhotos(8);
  for (const char* name :
       {"p10.mov", "p11.mov", "p12.mov", "p10.AAE", "notes.txt", ".hidden", "Thumbs.db"})
    WriteFile(photos / name, "x");
  fs::create_directories(photos / "raw");
  WriteFile(photos / "raw/p10.cr2", "x");
  ASSERT_EQ(RunMasked().code, 0);
  EXPECT_THAT(Report(), HasSubstr("files in photos that are no photographs were left out: 1 .aae "
                                  "(p10.AAE), 1 .cr2 (p10.cr2), "
                                  "3 .mov (p10.mov, p11.mov ...), 1 .txt (notes.txt)"));
}

TEST_F(CaptureProgram, OrdinaryFolderWarnsOfNoFilesAndTellsOfFewPhotographs) {
  WritePhotos(9);
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(Report(), ::testing::Not(HasSubstr("no photographs")));
  EXPECT_THAT(Report(), HasSubstr("there are only 9 photographs"));
  EXPECT_THAT(outcome.output, HasSubstr("no focal length"))
      << "nothing has EXIF, which is accepted";
  EXPECT_THAT(Report(), HasSubstr("\"focal_known\": false"));
}

TEST_F(CaptureProgram, EmptyFolderIsAnInputError) {
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("has no photographs"));
  EXPECT_THAT(outcome.output, HasSubstr("RAW: .cr2"));
  EXPECT_FALSE(fs::exists(images));
}

TEST_F(CaptureProgram, PicturesOfOtherFormatsAreCountedAndWhatToDoIsSaid) {
  WriteFile(photos / "a.webp", "");
  WriteFile(photos / "b.ppm", "");
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("1 .ppm (b.ppm), 1 .webp (a.webp)"));
  EXPECT_THAT(outcome.output, HasSubstr("as JPEG or PNG"));
}

TEST_F(CaptureProgram, SinglePhotographOfAnotherSizeIsNamedInAWarning) {
  WritePhotos(8);
  WriteImage(photos / "other.jpg", MakeTestPhoto(8, 200, 120, TestWall::kDark).image);
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(Report(), HasSubstr("different sizes: 8 are 180 x 120, 1 is 200 x 120: other.jpg"));
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

TEST_F(CaptureProgram, DamageOfTwoKindsIsToldInOneRun) {
  WritePhotos(9);
  WriteFile(photos / "p12.jpg", "no picture");
  const std::string bytes = ReadFile(photos / "p15.jpg");
  WriteFile(photos / "p15.jpg", bytes.substr(0, bytes.size() / 2));
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("2 of 9 photographs cannot be read: p12.jpg, p15.jpg"));
}

TEST_F(CaptureProgram, PhotographsOfOddSizesAreNamed) {
  WritePhotos(8);
  int count = 0;
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(1, 20000), std::pair(30, 700)})
    WriteImage(photos / ("odd" + std::to_string(count++) + ".png"), Image8(width, height, 3, 128));
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3) << outcome.output;
  for (const char* named : {"odd0.png (1 x 1)", "odd1.png (1 x 20000)", "odd2.png (30 x 700)"})
    EXPECT_THAT(outcome.output, HasSubstr(named));
  EXPECT_FALSE(fs::exists(images));
}

/// A JPEG that says it is so large; it has the pixels of a small one.
void WriteGiant(const fs::path& path, int width, int height) {
  WriteImage(path, Image8(16, 16, 3, 128));
  std::string bytes = ReadFile(path);
  const std::size_t frame = bytes.find("\xff\xc0");  // length, bits, height, width
  ASSERT_NE(frame, std::string::npos);
  for (const auto& [at, value] : {std::pair{5, height}, {7, width}}) {
    bytes[frame + at] = static_cast<char>(value >> 8);
    bytes[frame + at + 1] = static_cast<char>(value & 255);
  }
  WriteFile(path, bytes);
}

TEST_F(CaptureProgram, PhotographBeyondTheMemoryIsNamedBeforeItIsRead) {
#if defined(KEYPOSE_SANITIZED)
  GTEST_SKIP() << "a sanitizer's shadow needs all of the address space";
#endif
  WritePhotos(8);
  WriteGiant(photos / "giant.jpg", 12000, 8000);
  const Outcome outcome = Run("", "ulimit -v 1300000; ");  // 1.3 GB, of the 1.4 that it needs
  EXPECT_EQ(outcome.code, 4) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("giant.jpg (12000 x 8000 pixels) needs 1.4 GB"));
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
  const Outcome outcome = RunMasked("", "ulimit -t 60; ");
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

TEST_F(CaptureProgram, CopiesAreAnInputError) {
  WritePhotos(8);
  fs::copy_file(photos / "p12.jpg", photos / "p99.jpg");
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("p99.jpg = p12.jpg"));
}

TEST_F(CaptureProgram, BlurredSetIsAnInputErrorThatNamesThemUnlessTheLimitsAllowIt) {
  for (int i = 0; i < 8; ++i) {
    const TestPhoto photo = MakeTestPhoto(i, 270, 180, TestWall::kDark);
    WriteImage(photos / ("p" + std::to_string(i) + ".jpg"),
               i < 4 ? photo.image : Blurred(photo.image, 4));
  }
  for (const char* limit : {"", "--max_bad_share 0.4"}) {
    const Outcome outcome = Run(limit);
    EXPECT_EQ(outcome.code, 3) << limit;
    EXPECT_THAT(outcome.output,
                HasSubstr("4 of 8 photographs are blurred: p4.jpg, p5.jpg, p6.jpg, p7.jpg"));
    EXPECT_FALSE(fs::exists(images));
  }
  EXPECT_EQ(Run("--max_bad_share 0.5").code, 0);
  EXPECT_THAT(Report(), HasSubstr("blurred"));
  EXPECT_EQ(Run("--overwrite --min_sharpness 0").code, 0);
}

TEST_F(CaptureProgram, APhotographFarLessCrispThanTheOthersIsNamed) {
  for (int i = 0; i < 8; ++i) {
    const TestPhoto photo = MakeTestPhoto(i, 270, 180, TestWall::kDark);
    WriteImage(photos / ("p" + std::to_string(i) + ".jpg"),
               i != 5 ? photo.image : Blurred(photo.image, 2));
  }
  ASSERT_EQ(Run("--min_sharpness 0.01").code, 0);
  EXPECT_THAT(Report(), HasSubstr("\"blurred\": [\n   \"p5.jpg\"\n  ]"));
}

// As many as are asked for are enough: LargePhotographsHaveMasksOfTheirSizeInAGibibyte.
TEST_F(CaptureProgram, SmallSetIsAnInputErrorWhereMoreAreAskedFor) {
  WritePhotos(8);
  EXPECT_EQ(Run("--min_images 9").code, 3);
  EXPECT_FALSE(fs::exists(images));
}

}  // namespace keypose::capture::photograph_faults_test
