// Parts of the segmentation: the pixel classifier, the empty set, shadows.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "capture/segmentation/empty_set.h"
#include "capture/segmentation/masking.h"
#include "capture/segmentation/pixel_classifier.h"
#include "capture/segmentation/set_rounds.h"
#include "capture/testing/test_images.h"
#include "core/numbers/parallel.h"

namespace keypose::capture::set_rounds_test {

/// Object where exactly one of two features is high: no single decision separates the two.
PixelSamples Crossed(int seed) {
  PixelSamples samples;
  for (int i = 0; i < 400; ++i) {
    PixelFeatures f{};
    for (std::size_t k = 0; k < f.size(); ++k)
      f[k] = static_cast<std::uint8_t>(
          (i * 37 + static_cast<int>(k) * 101 + seed * 13 + i * i * 7) % 64);
    f[0] = static_cast<std::uint8_t>((i * 29 + seed) % 64);
    f[1] = static_cast<std::uint8_t>((i * 23 + i / 64 + seed) % 64);
    samples.features.push_back(f);
    samples.object.push_back((f[0] >= 32) != (f[1] >= 32));
  }
  return samples;
}

TEST(PixelClassifier, LearnsWhatTwoFeaturesTellOnlyTogether) {
  const PixelSamples a = Crossed(1), b = Crossed(2), unseen = Crossed(3);
  const PixelClassifier classifier({&a, &b}, {});
  int right = 0;
  for (std::size_t i = 0; i < unseen.features.size(); ++i)
    right += (classifier.Odds(unseen.features[i], 6) > 0) == (unseen.object[i] != 0);
  EXPECT_GT(right, 340);
}

TEST(PixelClassifier, SameOddsForAnyThreadCountAndNoneWithoutBothKinds) {
  const PixelSamples samples = Crossed(1);
  SetThreadCount(1);
  const PixelClassifier one({&samples}, {});
  SetThreadCount(4);
  const PixelClassifier four({&samples}, {});
  SetThreadCount(0);
  for (const PixelFeatures& f : samples.features) EXPECT_EQ(one.Odds(f, 6), four.Odds(f, 6));
  PixelSamples background = samples;
  background.object.assign(background.object.size(), 0);
  EXPECT_EQ(PixelClassifier({&background}, {}).Odds(samples.features[0], 6), 0);
}

TEST(FindTakes, SplitsWhereTheSurroundingsChange) {
  std::vector<Image8> images;
  for (int i = 0; i < 5; ++i) images.push_back(MakeTestPhoto(i, 240, 160, TestWall::kLight).image);
  for (int i = 0; i < 3; ++i) images.push_back(MakeTestPhoto(i, 240, 160, TestWall::kDark).image);
  const std::vector<Take> takes = FindTakes(images, 0.06);
  ASSERT_GE(takes.size(), 2U);
  EXPECT_EQ(takes[0].images, (std::vector<std::size_t>{0, 1, 2, 3, 4}));
}

// The empty set is a median over a take, pixel by pixel.
TEST(FindTakes, ATakeHasOneSizeAlsoWhereSizesAlternate) {
  std::vector<Image8> images;
  for (int i = 0; i < 8; ++i)
    images.push_back(
        MakeTestPhoto(i, i % 2 ? 180 : 240, i % 2 ? 120 : 160, TestWall::kLight).image);
  const std::vector<Take> takes = FindTakes(images, 0.06);
  ASSERT_EQ(takes.size(), 2U);
  EXPECT_EQ(TakeOf(takes, 0).images, (std::vector<std::size_t>{0, 2, 4, 6}));
  EXPECT_EQ(TakeOf(takes, 3).images, (std::vector<std::size_t>{1, 3, 5, 7}));
}

TEST(EmptySet, IsWhatTheOthersOfTheTakeShow) {
  std::vector<Image8> lab, trimaps;
  for (int i = 0; i < 5; ++i) {
    Image8 image(80, 60, 3, 0), trimap(80, 60, 1, kBackground);
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 80; ++x) {
        image.at(x, y)[0] = static_cast<std::uint8_t>(x), image.at(x, y)[1] = 120,
                    image.at(x, y)[2] = static_cast<std::uint8_t>(130 + i % 2);
        if (std::abs(x - 15 * i) < 7 && y > 20) *trimap.at(x, y) = kObject, image.at(x, y)[0] = 250;
      }
    lab.push_back(image);
    trimaps.push_back(trimap);
  }
  const Image8 empty = EmptySet(lab, trimaps, {{0, 1, 2, 3, 4}}, 2);
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; ++x) ASSERT_EQ(*empty.at(x, y), x) << x << " " << y;
}

TEST(ShadowKinds, IsDarkerOfTheSameHueAndNothingElse) {
  Image8 empty(40, 30, 3), lab;
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x)
      empty.at(x, y)[0] = 200, empty.at(x, y)[1] = 132, empty.at(x, y)[2] = 140;
  const auto kind = [&](int light, int a, int b) {
    lab = empty;
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x)
        lab.at(x, y)[0] = static_cast<std::uint8_t>(light),
                  lab.at(x, y)[1] = static_cast<std::uint8_t>(a),
                  lab.at(x, y)[2] = static_cast<std::uint8_t>(b);
    return *ShadowKinds(lab, empty).at(20, 15);
  };
  EXPECT_GT(kind(140, 131, 136), 0);
  EXPECT_EQ(kind(200, 132, 140), 0);  // not darker
  EXPECT_EQ(kind(230, 132, 140), 0);  // lighter
  EXPECT_EQ(kind(140, 160, 136), 0);  // of another hue
  EXPECT_EQ(kind(30, 128, 130), 0);   // darker than a shadow
}

// A shadow as large as a third of the figure, next to it, in every photograph: colour alone
// classifies it as figure.
TEST(SegmentSet, LeavesOutTheShadowOnTheTable) {
  std::vector<Image8> images, truths;
  for (int i = 0; i < 12; ++i) {
    TestPhoto photo = MakeTestPhoto(i, 240, 160, TestWall::kLight);
    for (int y = 0; y < 160; ++y)
      for (int x = 0; x < 240; ++x) {
        const double dx = (x - 165) / 50.0, dy = (y - 118) / 16.0,
                     deep = 0.55 + 0.45 * std::clamp(4 * (dx * dx + dy * dy - 0.75), 0.0, 1.0);
        if (*photo.truth.at(x, y) == 0)
          for (int c = 0; c < 3; ++c)
            photo.image.at(x, y)[c] = static_cast<std::uint8_t>(photo.image.at(x, y)[c] * deep);
      }
    images.push_back(std::move(photo.image));
    truths.push_back(std::move(photo.truth));
  }
  const auto masks = SegmentSet(images, {}, {}, MaskOptions{});
  for (std::size_t i = 0; i < masks.size(); ++i) {
    double both = 0, either = 0;
    for (std::size_t p = 0; p < truths[i].data.size(); ++p) {
      both += masks[i].data[p] > 127 && truths[i].data[p] > 127;
      either += masks[i].data[p] > 127 || truths[i].data[p] > 127;
    }
    EXPECT_GT(both / either, 0.93) << "photograph " << i;
  }
}

constexpr int kRings = 12;
bool Pierced(int index) { return index % 4 == 1; }
constexpr double kHole = 4.5;

Eigen::Vector2d RingMiddle(int index) { return {130 + 5.0 * index, 120 + 10 * std::sin(index)}; }

/// A speckled disc that moves from photograph to photograph; some have a hole that shows the wall.
TestPhoto MakeRingPhoto(int index) {
  constexpr int kWidth = 320, kHeight = 240;
  TestPhoto photo{MakeTestWall(kWidth, kHeight, TestWall::kLight), Image8(kWidth, kHeight, 1, 0)};
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const double from = (Eigen::Vector2d(x, y) - RingMiddle(index)).norm();
      if (from > 85 || (Pierced(index) && from < kHole)) continue;
      *photo.truth.at(x, y) = 255;
      for (int c = 0; c < 3; ++c)
        photo.image.at(x, y)[c] =
            static_cast<std::uint8_t>(60 + 40 * c + (x * 31 + y * 17 + c * 7) % 29);
    }
  return photo;
}

// The masks of the previous round have filled all holes, and the other views do not contradict
// them.
TEST(SegmentByClassifier, OpensHolesThatMasksHaveFilled) {
  std::vector<Image8> images, told;
  for (int i = 0; i < kRings; ++i) images.push_back(MakeRingPhoto(i).image);
  Round round{images, {}, {}, {{}}, &told, {-3.0F, 2.0F}};
  for (int i = 0; i < kRings; ++i) {
    round.takes[0].images.push_back(static_cast<std::size_t>(i));
    Image8 mask = MakeRingPhoto(i).truth;
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x)
        if (Pierced(i) && (Eigen::Vector2d(x, y) - RingMiddle(i)).norm() < 2 * kHole)
          *mask.at(x, y) = 255;
    round.lab.push_back(LabOf(images[i]));
    round.trimaps.push_back(TrimapOf(mask));
    for (std::uint8_t& m : mask.data) m = m > 127;
    told.push_back(std::move(mask));
  }
  const std::vector<Image8> masks =
      SegmentByClassifier(round, std::vector<BoardOdds>(kRings), MaskOptions{});
  int open = 0, all = 0;
  for (int i = 0; i < kRings; ++i)
    for (int y = 0; y < images[0].height; ++y)
      for (int x = 0; Pierced(i) && x < images[0].width; ++x)
        if ((Eigen::Vector2d(x, y) - RingMiddle(i)).norm() < kHole)
          ++all, open += *masks[i].at(x, y) == 0;
  EXPECT_GT(open, 0.8 * all);
}

}  // namespace keypose::capture::set_rounds_test
