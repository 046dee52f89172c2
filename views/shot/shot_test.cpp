#include "views/shot/shot.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "views/decode/testing/test_film.h"

namespace keypose::shot_test {
namespace fs = std::filesystem;

class ShotTest : public ::testing::Test, public TestingFolder {
 protected:
  void PutPicture(const std::string& path, std::uint8_t value) const {
    fs::create_directories((folder_ / path).parent_path());
    WriteImage(folder_ / path, Image8(16, 12, 1, value));
  }
};

TEST_F(ShotTest, PicturesThatOnlyLocateReadsAreNamed) {
  std::filesystem::create_directories(folder_ / "cam1");
  Put("cam1/0001.exr", "any");
  try {
    OpenShot(folder_);
    FAIL() << "there is no camera";
  } catch (const InputError& fault) {
    EXPECT_NE(std::string(fault.what()).find("0001.exr and its like"), std::string::npos)
        << fault.what();
  }
}

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

TEST_F(ShotTest, PicturesWhoseNamesTellNoOrderAreSaid) {
  for (const char* name : {"DF_0001_X1", "DF_0001_X2", "DF_0002_X1", "DF_0002_X2"})
    PutPicture(std::string("cam1/") + name + ".png", 5);
  for (const char* name : {"1", "01", "2", "3"})
    PutPicture(std::string("cam2/") + name + ".png", 5);
  for (const char* name : {"1", "2", "3", "4"}) PutPicture(std::string("cam3/") + name + ".png", 5);
  const std::vector<std::string> notes = OpenShot(folder_).join.notes;
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_NE(notes[0].find("camera cam1: the picture "), std::string::npos) << notes[0];
  EXPECT_NE(notes[0].find("0001 and 1"), std::string::npos) << notes[0];
  EXPECT_NE(notes[1].find("has the frame number of"), std::string::npos) << notes[1];
}

TEST_F(ShotTest, BroadcastsAndCamcordersStreamsAreFilms) {
  if (!TestFilm::CanWrite("libx264")) GTEST_SKIP() << "libavcodec has no x264 here";
  fs::create_directories(folder_);
  TestFilmKind kind;
  kind.codec = "libx264";
  for (const char* name : {"cam1.ts", "cam2.MTS", "cam3.m2ts"})
    WriteTestFilm(folder_ / name, kind, EvenTimes(5, 3000));
  const Shot shot = OpenShot(folder_);
  EXPECT_EQ(shot.names(), (std::vector<std::string>{"cam1", "cam2", "cam3"}));
  for (const ShotCamera& camera : shot.cameras) EXPECT_EQ(camera.frames(), 5) << camera.name;
}

TEST_F(ShotTest, FilmsAreKnownByTheirContent) {
  fs::create_directories(folder_);
  TestFilmKind kind;
  kind.format = "matroska";
  WriteTestFilm(folder_ / "cam1", kind, EvenTimes(5, 3000));
  WriteTestFilm(folder_ / "cam2.dat", kind, EvenTimes(5, 3000));
  kind.format = "nut";
  WriteTestFilm(folder_ / "cam3.nut", kind, EvenTimes(5, 3000));
  WriteFile(folder_ / "notes.txt", "filmed on Monday");
  const Shot shot = OpenShot(folder_);
  EXPECT_EQ(shot.names(), (std::vector<std::string>{"cam1", "cam2", "cam3"}));
  for (const ShotCamera& camera : shot.cameras) EXPECT_EQ(camera.frames(), 5) << camera.name;
  EXPECT_EQ(shot.frames_per_second, 30);
}

TEST_F(ShotTest, WhatIsThereInsteadOfFilmsIsNamed) {
  fs::create_directories(folder_ / "cam1");
  WriteFile(folder_ / "cam1/0001.bmp", "BM");
  WriteFile(folder_ / "notes.txt", "filmed on Monday");
  try {
    OpenShot(folder_);
    FAIL() << "there is no camera";
  } catch (const InputError& fault) {
    const std::string text = fault.what();
    EXPECT_NE(text.find("1 .bmp (0001.bmp), 1 .txt (notes.txt); save pictures of other formats"),
              std::string::npos)
        << text;
  }
  WriteFile(folder_ / "cam1/film.flv", "FLV\1");
  try {
    OpenShot(folder_);
    FAIL() << "there is no camera";
  } catch (const InputError& fault) {
    EXPECT_NE(std::string(fault.what()).find("film.flv is a film in a folder of its own"),
              std::string::npos)
        << fault.what();
  }
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

TEST_F(ShotTest, APictureOfAnotherSizeIsNamed) {
  for (const char* name : {"a/1.png", "a/2.png"}) PutPicture(name, 90);
  WriteImage(folder_ / "a/3.png", Image8(12, 16, 1, 90));
  FrameReader reader(OpenShot(folder_).cameras[0].pictures);
  EXPECT_EQ(reader.Read(0, 3).width, 16);
  EXPECT_EQ(reader.Read(1, 3).width, 16);
  try {
    reader.Read(2, 3);
    FAIL();
  } catch (const InputError& fault) {
    const std::string words = fault.what();
    EXPECT_NE(words.find("3.png is 12 x 16 pixels, but 1.png beside it is 16 x 12"), words.npos)
        << words;
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
  fs::create_directories(folder_);
  TestFilmKind kind;
  kind.codec = "mjpeg", kind.pixels = AV_PIX_FMT_YUVJ420P, kind.unit = kind.rate = 25;
  WriteTestFilm(path, kind, EvenTimes(5, 1));
  const Shot shot = OpenShot(folder_);
  EXPECT_EQ(shot.cameras[0].frames(), 5);
  EXPECT_EQ(shot.frames_per_second, 25);
  FrameReader reader(shot.cameras[0].pictures);
  for (const int frame : {0, 1, 4, 2}) EXPECT_EQ(NumberIn(reader.Read(frame, 1)), frame);
}

TEST_F(ShotTest, FilmsOfOtherRatesAndStartsShowTheSameMoments) {
  fs::create_directories(folder_);
  TestFilmKind fast, slow;
  fast.rate = 50, slow.rate = 20;
  TestFilm a(folder_ / "a.mkv", fast), b(folder_ / "b.mkv", slow);
  // Numbers are moments, in hundredths of a second.
  for (int i = 0; i < 100; ++i) a.AddNumber(1800 * i, 2 * i);
  for (int i = 5; i < 40; ++i) b.AddNumber(4500 * i, 5 * i);
  a.Finish(), b.Finish();
  PutPicture("masks/b/0.png", 9);
  for (int i = 1; i < 35; ++i) PutPicture("masks/b/" + std::to_string(i) + ".png", 9 + i);
  const Shot shot = OpenShot(folder_);
  EXPECT_EQ(shot.frames_per_second, 20);
  ASSERT_EQ(shot.cameras[0].frames(), 35);
  ASSERT_EQ(shot.cameras[1].frames(), 35);
  EXPECT_LT(shot.join.worst_s, 0.0106) << "half a picture of the faster one, and rounded times";
  FrameReader first(shot.cameras[0].pictures), second(shot.cameras[1].pictures);
  for (int f = 0; f < 35; ++f) {
    const int moment = NumberIn(second.Read(f, 1));
    EXPECT_EQ(moment, 25 + 5 * f);
    EXPECT_LE(std::abs(NumberIn(first.Read(f, 1)) - moment), 1);
  }
  EXPECT_EQ(*FrameReader(shot.cameras[1].masks).Read(3, 1).at(1, 1), 12);
  EXPECT_EQ(OpenSeparateFilms(folder_)[0].frames(), 100);
  EXPECT_EQ(OpenFilmsToShow(folder_)[0].frames(), 35);
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
