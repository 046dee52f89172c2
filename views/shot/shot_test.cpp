#include "views/shot/shot.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::shot_test {
namespace fs = std::filesystem;

class ShotTest : public ::testing::Test, public TestingFolder {
 protected:
  void PutPicture(const std::string& path, std::uint8_t value) const {
    fs::create_directories((folder_ / path).parent_path());
    WriteImage(folder_ / path, Image8(16, 12, 1, value));
  }
};

TEST_F(ShotTest, CamerasAndFramesAreSortedByNumber) {
  for (const char* camera : {"cam10", "cam2"})
    for (const char* frame : {"9.png", "10.png"})
      PutPicture(std::string(camera) + "/" + frame, frame[0] == '9' ? 90 : 100);
  PutPicture("background/cam2.png", 7);
  const Shot shot = OpenShot(folder_);
  EXPECT_EQ(shot.names(), (std::vector<std::string>{"cam2", "cam10"}));
  EXPECT_FALSE(shot.has_masks());
  EXPECT_EQ(shot.cameras[0].plate, folder_ / "background/cam2.png");
  FrameReader reader(shot.cameras[0].pictures);
  EXPECT_EQ(*reader.Read(0, 1).at(3, 3), 90);
  EXPECT_EQ(*reader.Read(1, 1).at(3, 3), 100);
  EXPECT_THROW(reader.Read(2, 1), UsageError);
}

TEST_F(ShotTest, MasksAloneAreAShot) {
  PutPicture("masks/a/0.png", 255);
  PutPicture("masks/b/0.png", 255);
  const Shot shot = OpenShot(folder_);
  EXPECT_TRUE(shot.has_masks());
  EXPECT_EQ(shot.cameras[1].frames(), 1);
}

TEST_F(ShotTest, MasksAloneHaveTheRateOfTheirFilms) {
  PutPicture("masks/a/0.png", 255);
  EXPECT_EQ(OpenShot(folder_).frames_per_second, 0);
  WriteShotRate(folder_, 30 / 1.001);
  EXPECT_EQ(OpenShot(folder_).frames_per_second, 30 / 1.001);
  for (const char* wrong : {"{}", "[", R"({"fps": 0})", R"({"fps": "30"})"}) {
    WriteFile(folder_ / "rate.json", wrong);
    EXPECT_THROW(OpenShot(folder_), InputError) << wrong;
  }
}

TEST_F(ShotTest, MissingMasksAndEmptyFoldersAreErrors) {
  EXPECT_THROW(OpenShot(folder_), InputError);
  PutPicture("a/0.png", 1);
  PutPicture("a/1.png", 1);
  PutPicture("masks/a/0.png", 255);
  EXPECT_THROW(OpenShot(folder_), InputError);
}

TEST_F(ShotTest, FramesOfAVideoAreReadInAnyOrder) {
  const fs::path path = folder_ / "cam1.avi";
  cv::VideoWriter writer(path.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, {64, 48});
  if (!writer.isOpened()) GTEST_SKIP() << "this OpenCV writes no video";
  for (int i = 0; i < 5; ++i) writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(20 + 40 * i)));
  writer.release();
  const Shot shot = OpenShot(folder_);
  EXPECT_EQ(shot.cameras[0].frames(), 5);
  EXPECT_EQ(shot.frames_per_second, 25);
  FrameReader reader(shot.cameras[0].pictures);
  for (const int frame : {0, 1, 4, 2})  // JPEG within a video changes a level or two
    EXPECT_NEAR(*reader.Read(frame, 1).at(30, 20), 20 + 40 * frame, 4) << frame;
}

TEST_F(ShotTest, ABrokenVideoIsAnError) {
  std::filesystem::create_directories(folder_);
  WriteImage(folder_ / "x.png", Image8(4, 4, 1, 9));
  fs::rename(folder_ / "x.png", folder_ / "cam1.mp4");
  // A still picture may count as a video of one frame; what must not happen is an empty shot.
  try {
    EXPECT_EQ(OpenShot(folder_).cameras[0].frames(), 1);
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("cam1.mp4"), std::string::npos);
  }
}

}  // namespace keypose::shot_test
