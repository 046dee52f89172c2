// The program keypose-silhouettes on a film of a ball that rolls.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/testing_folder.h"
#include "views/shot/shot.h"

namespace keypose::capture {
namespace {
namespace fs = std::filesystem;

constexpr int kFrames = 3, kWidth = 160, kHeight = 120;
constexpr double kRate = 30;

cv::Mat Picture(int frame) {
  cv::Mat picture(kHeight, kWidth, CV_8UC3, cv::Scalar::all(150));
  cv::circle(picture, {60 + 10 * frame, 60}, 25, cv::Scalar(30, 40, 200), -1);
  return picture;
}

TEST(SilhouettesProgram, MasksGoWithTheRateOfTheFilms) {
  const TestingFolder folder;
  const fs::path root = folder.path();
  fs::create_directories(root / "shot/background");
  WriteImage(root / "shot/background/cam1.png", Image8(kWidth, kHeight, 3, 150));
  cv::VideoWriter writer((root / "shot/cam1.avi").string(),
                         cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), kRate, {kWidth, kHeight});
  ASSERT_TRUE(writer.isOpened());
  for (int f = 0; f < kFrames; ++f) writer.write(Picture(f));
  writer.release();
  const std::string command = std::string(KEYPOSE_BIN_DIR) + "/keypose-silhouettes --video " +
                              (root / "shot").string() + " --masked " + (root / "masked").string() +
                              " > " + (root / "log.txt").string() + " 2>&1";
  ASSERT_EQ(WEXITSTATUS(std::system(command.c_str())), 0) << ReadFile(root / "log.txt");
  const Shot masked = OpenShot(root / "masked");
  ASSERT_EQ(masked.cameras.size(), 1u);
  EXPECT_EQ(masked.frames_per_second, kRate);
  FrameReader reader(masked.cameras[0].masks);
  for (int f = 0; f < kFrames; ++f) {
    const Image8 mask = reader.Read(f, 1);
    EXPECT_EQ(*mask.at(60 + 10 * f, 60), 255) << f;
    EXPECT_EQ(*mask.at(10, 10), 0) << f;
  }
}

}  // namespace
}  // namespace keypose::capture
