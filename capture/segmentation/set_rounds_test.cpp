#include "capture/segmentation/set_rounds.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "capture/segmentation/empty_set.h"
#include "capture/testing/test_images.h"

namespace keypose::capture::set_rounds_test {

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
