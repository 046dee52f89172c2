// Scores of textured performances, on pictures with known differences.
#include "synth/scores/video_score.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/pictures/image_quality.h"

namespace keypose::synth::video_score_test {

constexpr int kSize = 60;

/// A grey square on a black film, its outline, and a render of it.
struct Square : ::testing::Test {
  Image8 film{kSize, kSize, 3, 0}, render{kSize, kSize, 4, 0}, outline{kSize, kSize, 1, 0};
  Square() {
    for (int y = 10; y < 50; ++y)
      for (int x = 10; x < 50; ++x) {
        *outline.at(x, y) = 255;
        for (int c = 0; c < 3; ++c) film.at(x, y)[c] = render.at(x, y)[c] = 100;
        render.at(x, y)[3] = 255;
      }
  }
};

TEST_F(Square, EqualPicturesDoNotDiffer) {
  const VideoErrors errors = ComparePictures(film, render, outline);
  EXPECT_EQ(errors.squares, 0);
  EXPECT_EQ(errors.inside, 38 * 38);  // without the border
  EXPECT_EQ(errors.covered, 38 * 38);
  EXPECT_EQ(errors.values, 3 * 38 * 38);
  EXPECT_EQ(errors.rim_values, 3 * (38 * 38 - 28 * 28));
}

TEST_F(Square, EvenDifferenceHasItsPsnr) {
  for (std::size_t i = 0; i < outline.data.size(); ++i)
    for (int c = 0; c < 3; ++c) render.data[4 * i + c] += 5;
  const VideoErrors errors = ComparePictures(film, render, outline);
  EXPECT_NEAR(Psnr(errors.squares, errors.values), 20 * std::log10(255.0 / 5), 1e-9);
  EXPECT_LT(errors.halo, 0) << "away from the black around";
}

TEST_F(Square, RimOfBackgroundIsAHalo) {
  for (int y = 10; y < 50; ++y)
    for (int x = 10; x < 16; ++x)
      for (int c = 0; c < 3; ++c) render.at(x, y)[c] = 50;  // half of it is background
  const VideoErrors errors = ComparePictures(film, render, outline);
  EXPECT_NEAR(errors.halo / errors.halo_scale, 0.5 * 5 * 38 / (38 * 38 - 28 * 28), 1e-9);
  EXPECT_GT(errors.rim_squares, 0);
  EXPECT_EQ(errors.rim_squares, errors.squares);
}

TEST_F(Square, PixelsThatTheMeshDoesNotCoverAreCountedApart) {
  for (int y = 10; y < 50; ++y)
    for (int x = 30; x < 50; ++x) render.at(x, y)[3] = 0;
  const VideoErrors errors = ComparePictures(film, render, outline);
  EXPECT_EQ(errors.inside, 38 * 38);
  EXPECT_EQ(errors.covered, 38 * 19);
  EXPECT_EQ(errors.squares, 0);
}

}  // namespace keypose::synth::video_score_test
