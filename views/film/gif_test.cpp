// GIF as read by OpenCV (libav's decoder), and its times as the bytes say them.
#include "views/film/gif.h"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "core/numbers/parallel.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "views/film/frame_painter.h"
#include "views/film/testing/plain_pictures.h"

namespace keypose::gif_test {

namespace fs = std::filesystem;

class Gif : public ::testing::Test, public TestingFolder {
 protected:
  fs::path File() const { return folder_ / "film.gif"; }
  void Write(const std::vector<Image8>& pictures, double fps, const GifOptions& options = {}) {
    GifWriter writer(File(), fps, options);
    for (const Image8& picture : pictures) writer.Add(picture);
    writer.Finish();
  }
  std::string Bytes() const {
    std::ostringstream bytes;
    bytes << std::ifstream(File(), std::ios::binary).rdbuf();
    return bytes.str();
  }
  std::vector<cv::Mat> Read() const {
    cv::VideoCapture film(File().string(), cv::CAP_FFMPEG);
    std::vector<cv::Mat> pictures;
    for (cv::Mat picture; film.read(picture);) pictures.push_back(picture.clone());
    return pictures;
  }
};

std::vector<Image8> FlatPictures(int count) {
  std::vector<Image8> pictures;
  for (int i = 0; i < count; ++i)
    pictures.push_back(Flat(24, 16, Rgb(2 * i, 255 - 3 * i, i % 2 * 90)));
  return pictures;
}

/// What the blocks of a GIF file say. Source: GIF89a specification, CompuServe 1990.
struct Blocks {
  std::vector<int> delays;       // hundredths, per picture
  std::vector<int> left, width;  // of the part that is drawn
  int loops = -1;                // 0: for ever
  int width_px = 0, height_px = 0;

  explicit Blocks(const std::string& bytes) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(bytes.at(i)); };
    const auto word = [&](std::size_t i) { return byte(i) + 256 * byte(i + 1); };
    EXPECT_EQ(bytes.substr(0, 6), "GIF89a");
    width_px = word(6), height_px = word(8);
    const auto table = [&](int flags) { return flags & 128 ? 3u << ((flags & 7) + 1) : 0u; };
    std::size_t at = 13 + table(byte(10));
    const auto skip = [&] {
      while (byte(at) != 0) at += byte(at) + 1;
      ++at;
    };
    while (byte(at) != 0x3b) {
      if (byte(at) == 0x2c) {
        left.push_back(word(at + 1));
        width.push_back(word(at + 5));
        at += 11 + table(byte(at + 9));
      } else {
        EXPECT_EQ(byte(at), 0x21);
        if (byte(at + 1) == 0xf9) delays.push_back(word(at + 4));
        if (byte(at + 1) == 0xff) loops = word(at + 16);
        at += 2;
      }
      skip();
    }
    EXPECT_EQ(at + 1, bytes.size());
  }
};

TEST_F(Gif, AnotherProgramReadsEveryPictureInOrderWithItsColours) {
  const std::vector<Image8> pictures = FlatPictures(60);
  Write(pictures, 24);
  const std::vector<cv::Mat> read = Read();
  ASSERT_EQ(read.size(), pictures.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    ASSERT_EQ(read[i].cols, 24);
    const cv::Vec3b bgr = read[i].at<cv::Vec3b>(8, 12);
    for (int k = 0; k < 3; ++k) EXPECT_EQ(bgr[2 - k], pictures[i].at(12, 8)[k]) << i;
  }
}

TEST_F(Gif, TimesDoNotDriftAndItLoopsForEver) {
  for (const double fps : {24.0, 23.976, 12.0, 30.0, 50.0, 7.0}) {
    Write(FlatPictures(80), fps);
    const Blocks blocks(Bytes());
    ASSERT_EQ(blocks.delays.size(), 80u) << fps;
    EXPECT_EQ(blocks.loops, 0);
    int begin = 0;
    for (std::size_t i = 0; i < 80; ++i) {
      EXPECT_LE(std::abs(begin - 100 * static_cast<double>(i) / fps), 0.5 + 1e-9) << fps;
      begin += blocks.delays[i];
    }
    EXPECT_LE(std::abs(begin - 8000 / fps), 0.5 + 1e-9) << "the whole, at " << fps;
  }
}

TEST_F(Gif, NoPictureIsShorterThanBrowsersShowAndTheWholeLastsAsLong) {
  Write(FlatPictures(80), 80);
  const Blocks blocks(Bytes());
  int sum = 0;
  for (const int delay : blocks.delays) {
    EXPECT_GE(delay, 2);
    sum += delay;
  }
  EXPECT_EQ(sum, 100);
  EXPECT_GE(blocks.delays.size(), 38u);
}

TEST_F(Gif, EqualPicturesBecomeOneThatLastsLonger) {
  const std::vector<Image8> p = FlatPictures(3);
  Write({p[0], p[0], p[0], p[1], p[2], p[2]}, 25);
  EXPECT_EQ(Blocks(Bytes()).delays, (std::vector<int>{12, 4, 8}));
}

TEST_F(Gif, OnePictureIsAFile) {
  Write({Flat(33, 21, {9, 8, 7})}, 24);
  const auto read = Read();
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].at<cv::Vec3b>(20, 32), cv::Vec3b(7, 8, 9));
}

double MeanOf(const cv::Mat& picture, int x0, int y0, int channel) {
  double sum = 0;
  for (int y = y0; y < y0 + 8; ++y)
    for (int x = x0; x < x0 + 8; ++x) sum += picture.at<cv::Vec3b>(y, x)[2 - channel];
  return sum / 64;
}

TEST_F(Gif, DitheringKeepsTheMeanColourAndEachPixelNear) {
  std::vector<Image8> pictures;
  for (int i = 0; i < 12; ++i) pictures.push_back(BallAt(40 + 6 * i));
  Write(pictures, 24);
  const std::vector<cv::Mat> read = Read();
  ASSERT_EQ(read.size(), 12u);
  double worst_mean = 0, worst_pixel = 0;
  for (std::size_t i = 0; i < 12; ++i)
    for (int y = 0; y + 8 <= 120; y += 8)
      for (int x = 0; x + 8 <= 160; x += 8)
        for (int k = 0; k < 3; ++k) {
          double sum = 0;
          for (int v = y; v < y + 8; ++v)
            for (int u = x; u < x + 8; ++u) {
              const int given = pictures[i].at(u, v)[k];
              sum += given;
              worst_pixel = std::max<double>(worst_pixel,
                                             std::abs(read[i].at<cv::Vec3b>(v, u)[2 - k] - given));
            }
          worst_mean = std::max(worst_mean, std::abs(MeanOf(read[i], x, y, k) - sum / 64));
        }
  EXPECT_LT(worst_mean, 3);
  EXPECT_LT(worst_pixel, 48);
}

TEST_F(Gif, OnlyWhatChangesIsDrawnAgain) {
  Write({BallAt(40), BallAt(44), BallAt(48)}, 24);
  const Blocks blocks(Bytes());
  ASSERT_EQ(blocks.width.size(), 3u);
  EXPECT_EQ(blocks.width[0], 160);
  EXPECT_LT(blocks.width[1], 80);
  EXPECT_GT(blocks.left[1], 0);
}

TEST_F(Gif, PicturesGetTheWantedHeightButAreNeverEnlarged) {
  Write({Image8(96, 72, 3, 5)}, 24, {48, 12});
  EXPECT_EQ(Blocks(Bytes()).width_px, 64);
  EXPECT_EQ(Blocks(Bytes()).height_px, 48);
  Write({Image8(97, 31, 3, 5)}, 24, {48, 12});
  EXPECT_EQ(Blocks(Bytes()).width_px, 97);
  EXPECT_EQ(Blocks(Bytes()).height_px, 31);
}

TEST_F(Gif, AlphaShowsTheFilmsBackground) {
  Image8 picture(8, 8, 4);
  Write({picture}, 24);
  const cv::Vec3b bgr = Read().at(0).at<cv::Vec3b>(4, 4);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(bgr[2 - k], kFilmBackground[k]);
}

TEST_F(Gif, WhatComesAfterTheLongestTimeIsLeftOutAndSaid) {
  const std::vector<Image8> pictures = FlatPictures(30);
  GifWriter writer(File(), 10, {480, 2});
  for (int i = 0; i < 20; ++i) writer.Add(pictures[i]);
  EXPECT_FALSE(writer.Shortened());
  for (int i = 20; i < 30; ++i) writer.Add(pictures[i]);
  EXPECT_TRUE(writer.Shortened());
  writer.Finish();
  EXPECT_EQ(Blocks(Bytes()).delays, std::vector<int>(20, 10));
}

TEST_F(Gif, SameBytesForAnyThreadCount) {
  const auto bytes = [&](int threads) {
    SetThreadCount(threads);
    Write({BallAt(40), BallAt(50)}, 24, {90, 12});
    SetThreadCount(0);
    return Bytes();
  };
  const std::string one = bytes(1);
  EXPECT_GT(one.size(), 1000u);
  EXPECT_TRUE(one == bytes(3));
}

TEST_F(Gif, FaultsThrow) {
  GifWriter writer(File(), 24);
  EXPECT_THROW(writer.Finish(), InputError) << "no pictures";
  EXPECT_THROW(writer.Add(Image8()), InputError);
  writer.Add(Flat(8, 8, {1, 2, 3}));
  EXPECT_THROW(writer.Add(Flat(9, 8, {1, 2, 3})), InputError);
  EXPECT_THROW(writer.Add(Image8(8, 8, 1)), InputError);
  EXPECT_THROW(GifWriter(folder_ / "no such folder" / "film.gif", 24), DiskError);
}

TEST_F(Gif, FullDiskThrowsDiskError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no device that is always full";
  GifWriter writer("/dev/full", 24);
  writer.Add(BallAt(50));
  EXPECT_THROW(writer.Finish(), DiskError);
}

}  // namespace keypose::gif_test
