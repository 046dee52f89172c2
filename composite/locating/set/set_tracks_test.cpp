#include "composite/locating/set/set_tracks.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <random>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"

namespace keypose::composite::set_tracks_test {

constexpr int kWidth = 320, kHeight = 200, kPictures = 5;
const Eigen::Vector2d kWay(2.3, -0.7);  // px from one picture to the next

/// Waves of many directions, or of one: then nothing tells how it moves along them.
Image8 Pattern(int picture, bool of_one_direction) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> even(0, 1);
  Image8 image(kWidth, kHeight, 1);
  std::vector<double> levels(image.data.size(), 128);
  for (int wave = 0; wave < 24; ++wave) {
    const double angle = of_one_direction ? 1.2 : 6.3 * even(random);
    const double per_px = 0.1 + 0.3 * even(random), phase = 6.3 * even(random);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const double across =
            (x - picture * kWay.x()) * std::cos(angle) + (y - picture * kWay.y()) * std::sin(angle);
        levels[static_cast<std::size_t>(y) * kWidth + x] += 9 * std::sin(per_px * across + phase);
      }
  }
  for (std::size_t i = 0; i < levels.size(); ++i)
    image.data[i] = static_cast<std::uint8_t>(std::clamp(std::lround(levels[i]), 0L, 255L));
  return image;
}

std::vector<SetTrack> TracksOf(bool of_one_direction, const Image8* figure = nullptr) {
  std::vector<Image8> pictures;
  for (int i = 0; i < kPictures; ++i) pictures.push_back(Pattern(i, of_one_direction));
  std::vector<SetPicture> set;
  for (const Image8& picture : pictures) set.push_back({&picture, figure});
  return FindSetTracks(set);
}

TEST(SetTracks, PlacesAreFollowedToATenthOfAPixel) {
  const std::vector<SetTrack> tracks = TracksOf(false);
  int whole = 0, sightings = 0;
  double sum = 0;
  for (const SetTrack& track : tracks) {
    whole += SizeOf(track) == kPictures;
    for (const SetSighting& sighting : track) {
      const Eigen::Vector2d off =
          sighting.pixel - track[0].pixel - (sighting.picture - track[0].picture) * kWay;
      EXPECT_LT(off.norm(), 0.5);
      sum += off.squaredNorm(), ++sightings;
      EXPECT_LT(off.dot(sighting.information * off), 16) << "within four deviations";
    }
  }
  EXPECT_GT(whole, 100);
  EXPECT_LT(std::sqrt(sum / sightings), 0.1);
}

TEST(SetTracks, AnEdgeIsKnownAcrossOnly) {
  const Eigen::Vector2d across(std::cos(1.2), std::sin(1.2));
  const std::vector<SetTrack> tracks = TracksOf(true);
  ASSERT_GT(tracks.size(), 100u);
  for (const SetTrack& track : tracks) {
    const SetSighting& last = track.back();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> known(last.information);
    EXPECT_LT(known.eigenvalues()[0], 1e-3 * known.eigenvalues()[1]);
    EXPECT_GT(std::abs(known.eigenvectors().col(1).dot(across)), 0.999);
    const Eigen::Vector2d off =
        last.pixel - track[0].pixel - (last.picture - track[0].picture) * kWay;
    EXPECT_LT(std::abs(off.dot(across)), 0.1);
  }
}

TEST(SetTracks, TheCharacterIsLeftOut) {
  Image8 figure(kWidth, kHeight, 1);
  for (int y = 50; y < 150; ++y) std::fill(figure.at(100, y), figure.at(200, y), 255);
  for (const SetTrack& track : TracksOf(false, &figure))
    for (const SetSighting& s : track)
      EXPECT_FALSE(s.pixel.x() > 98 && s.pixel.x() < 202 && s.pixel.y() > 48 && s.pixel.y() < 152);
}

TEST(SetTracks, ThreadsDoNotChangeThem) {
  SetThreadCount(1);
  const std::vector<SetTrack> one = TracksOf(false);
  SetThreadCount(3);
  const std::vector<SetTrack> three = TracksOf(false);
  SetThreadCount(0);
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].size(), three[i].size());
    EXPECT_EQ(one[i].back().pixel, three[i].back().pixel);
  }
}

}  // namespace keypose::composite::set_tracks_test
