// The program keypose-silhouettes on a film of a ball that rolls.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "views/shot/shot.h"

namespace keypose::capture::silhouettes_program_test {
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
  const std::string command = BinFolder() + "/keypose-silhouettes --video " +
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

TEST(SilhouettesProgram, APlateThatTheFilmDiffersFromEverywhereIsDoubted) {
  const TestingFolder folder;
  const fs::path root = folder.path();
  fs::create_directories(root / "shot/background");
  fs::create_directories(root / "shot/cam1");
  WriteImage(root / "shot/background/cam1.png", Image8(kWidth, kHeight, 3, 150));
  for (int f = 0; f < kFrames; ++f) {  // two colours by turns, as dithering mixes them
    Image8 picture(kWidth, kHeight, 3, 60);
    for (int y = 0; y < kHeight; ++y)
      for (int x = (y + f) % 2; x < kWidth; x += 2)
        std::fill_n(picture.at(x, y), 3, std::uint8_t{240});
    WriteImage(root / "shot/cam1" / (std::to_string(f) + ".png"), picture);
  }
  const std::string command = BinFolder() + "/keypose-silhouettes --video " +
                              (root / "shot").string() + " --masked " + (root / "masked").string() +
                              " > " + (root / "log.txt").string() + " 2>&1";
  ASSERT_EQ(WEXITSTATUS(std::system(command.c_str())), 0) << ReadFile(root / "log.txt");
  EXPECT_NE(ReadFile(root / "log.txt").find("camera cam1: 3 of its 3 masks are nearly the whole"),
            std::string::npos)
      << ReadFile(root / "log.txt");
}

/// A film of a ball with a stripe that rolls before a wall with pictures, as numbered pictures.
cv::Mat PictureInARoom(int frame, cv::Mat* truth) {
  cv::Mat picture(kHeight, kWidth, CV_8UC3, cv::Scalar(150, 160, 170));
  for (int i = 0; i < 5; ++i)
    cv::rectangle(picture, cv::Rect(10 + 32 * i, 15 + 9 * (i % 3), 16, 20),
                  cv::Scalar(40 * i, 220 - 30 * i, 90), -1);
  picture(cv::Rect(0, 90, kWidth, 30)).setTo(cv::Scalar(70, 80, 90));
  const cv::Point centre(45 + 3 * frame, 70);
  cv::circle(picture, centre, 24, cv::Scalar(30, 40, 200), -1);
  cv::line(picture, centre - cv::Point(10, frame - 10), centre + cv::Point(10, frame - 10),
           cv::Scalar(20, 20, 60), 6);
  if (truth) {
    *truth = cv::Mat::zeros(kHeight, kWidth, CV_8U);
    cv::circle(*truth, centre, 24, cv::Scalar(255), -1);
  }
  return picture;
}

TEST(SilhouettesProgram, FilmWithoutThePictureOfTheEmptySetIsMaskedByWhatMoves) {
  const TestingFolder folder;
  const fs::path root = folder.path();
  fs::create_directories(root / "shot/cam1");
  constexpr int kRolls = 24;
  for (int f = 0; f < kRolls; ++f) {
    cv::Mat picture;
    cv::cvtColor(PictureInARoom(f, nullptr), picture, cv::COLOR_BGR2RGB);
    Image8 image(kWidth, kHeight, 3);
    image.data.assign(picture.datastart, picture.dataend);
    char name[16];
    std::snprintf(name, sizeof name, "%03d.png", f);
    WriteImage(root / "shot/cam1" / name, image);
  }
  const std::string command = BinFolder() + "/keypose-silhouettes --video " +
                              (root / "shot").string() + " --masked " + (root / "masked").string() +
                              " --network false --figure 'cam1/3:55,70' > " +
                              (root / "log.txt").string() + " 2>&1";
  ASSERT_EQ(WEXITSTATUS(std::system(command.c_str())), 0) << ReadFile(root / "log.txt");
  const Shot masked = OpenShot(root / "masked");
  FrameReader reader(masked.cameras.at(0).masks);
  for (int f = 0; f < kRolls; f += 4) {
    cv::Mat truth;
    PictureInARoom(f, &truth);
    const Image8 mask = reader.Read(f, 1);
    int both = 0, either = 0;
    for (std::size_t p = 0; p < mask.data.size(); ++p) {
      both += mask.data[p] > 127 && truth.data[p];
      either += mask.data[p] > 127 || truth.data[p];
    }
    EXPECT_GT(static_cast<double>(both) / either, 0.93) << f;
  }
}

TEST(SilhouettesProgram, StrokeInACameraThatIsNotThereIsAUsageError) {
  const TestingFolder folder;
  const fs::path root = folder.path();
  fs::create_directories(root / "shot/cam1");
  for (const char* name : {"000.png", "001.png"})
    WriteImage(root / "shot/cam1" / name, Image8(kWidth, kHeight, 3, 90));
  const std::string command = BinFolder() + "/keypose-silhouettes --video " +
                              (root / "shot").string() + " --masked " + (root / "masked").string() +
                              " --figure 'cam7/0:5,5' > " + (root / "log.txt").string() + " 2>&1";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 2);
  EXPECT_NE(ReadFile(root / "log.txt").find("those are: cam1"), std::string::npos)
      << ReadFile(root / "log.txt");
}

}  // namespace keypose::capture::silhouettes_program_test
