// keypose-capture on photographs as large as telephones make them: read at a part of their size.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "capture/testing/capture_program.h"
#include "capture/testing/test_images.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/text/files.h"
#include "core/pictures/image_turns.h"

namespace keypose::capture::large_photographs_test {

constexpr int kScale = 3, kWidth = 1334, kHeight = 889;  // no multiples of eight

/// Each pixel as a square of kScale pixels.
Image8 Magnified(const Image8& image) {
  Image8 large(kScale * image.width, kScale * image.height, image.channels);
  for (int y = 0; y < large.height; ++y)
    for (int x = 0; x < large.width; ++x)
      std::copy_n(image.at(x / kScale, y / kScale), image.channels, large.at(x, y));
  return large;
}

double Overlap(const Image8& mask, const Image8& truth) {
  EXPECT_EQ(mask.width, truth.width);
  EXPECT_EQ(mask.height, truth.height);
  if (mask.data.size() != truth.data.size()) return 0;
  double both = 0, either = 0;
  for (std::size_t i = 0; i < mask.data.size(); ++i)
    both += mask.data[i] && truth.data[i], either += mask.data[i] || truth.data[i];
  return both / either;
}

// Photographs of 4002 x 2667 pixels: one upright, one stored on its side, one in portrait.
TEST_F(CaptureProgram, LargePhotographsHaveMasksOfTheirSizeInAGibibyte) {
  constexpr int kPhotographs = 5, kStoredOnItsSide = 2, kPortrait = 4;
  std::vector<Image8> truths;
  for (int i = 0; i < kPhotographs; ++i) {
    const bool portrait = i == kPortrait;
    TestPhoto photo =
        MakeTestPhoto(i, portrait ? kHeight : kWidth, portrait ? kWidth : kHeight, TestWall::kDark);
    ExifToWrite exif;
    if (i == kStoredOnItsSide) {
      exif.orientation = 6;
      photo.image = QuarterTurned(QuarterTurned(QuarterTurned(photo.image)));
    }
    if (portrait) photo.truth = QuarterTurned(photo.truth);
    WriteImage(photos / ("p" + std::to_string(i) + ".jpg"), Magnified(photo.image), 92, &exif);
    truths.push_back(Magnified(photo.truth));
  }
  const Outcome outcome = Run("--min_images 5");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const ImageSet set = ReadImageSet(images);
  for (int i = 0; i < kPhotographs; ++i) {
    const std::string name = "p" + std::to_string(i) + ".jpg";
    EXPECT_EQ(set.images[i].width, kScale * kWidth) << name;
    EXPECT_EQ(set.images[i].height, kScale * kHeight) << name;
    EXPECT_EQ(ReadFile(images / name) == ReadFile(photos / name),
              i != kStoredOnItsSide && i != kPortrait)
        << name;
    EXPECT_GT(Overlap(ReadImage(images / ("masks/" + name + ".png"), 1), truths[i]), 0.99) << name;
  }
  EXPECT_LT(nlohmann::json::parse(Report()).at("peak_bytes"), 1 << 30);
}

}  // namespace keypose::capture::large_photographs_test
