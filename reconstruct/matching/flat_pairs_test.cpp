#include "reconstruct/matching/flat_pairs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <random>

#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::flat_pairs_test {

using Eigen::Vector3d;

constexpr int kMat = 80, kFigure = 40;  // points

/// Photographs from above of a mat in the plane z = 0 and, on it, a figure. Feature f is point f.
std::vector<Features> Photographs(int count) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Vector3d> points;
  for (int p = 0; p < kMat; ++p) points.emplace_back(unit(random), unit(random), 0);
  for (int p = 0; p < kFigure; ++p)
    points.emplace_back(0.3 * unit(random), 0.3 * unit(random), 0.5 + 0.4 * unit(random));
  Camera camera;
  camera.width = 1200, camera.height = 900;
  camera.fx = camera.fy = 1200, camera.cx = 600, camera.cy = 450;
  std::vector<Features> features;
  for (int i = 0; i < count; ++i) {
    const double turn = 0.35 * i;
    const View view = testing::LookFrom({3 * std::sin(turn), -3 * std::cos(turn), 2.5}, camera, "");
    Features f;
    f.positions.resize(kMat + kFigure, 2);
    f.scales = Eigen::VectorXf::Constant(kMat + kFigure, 2);
    for (int p = 0; p < kMat + kFigure; ++p)
      f.positions.row(p) = view.Project(points[p]).transpose().cast<float>();
    features.push_back(f);
  }
  return features;
}

PairMatches Pair(int i, int j, int begin, int end) {
  PairMatches pair{i, j, {}};
  for (int p = begin; p < end; ++p)
    pair.features.emplace_back(static_cast<std::uint32_t>(p), static_cast<std::uint32_t>(p));
  return pair;
}

TEST(FlatPairs, TheFigureIsOffTheMatsPlane) {
  const auto features = Photographs(2);
  EXPECT_LE(MatchesOffPlane(features[0], features[1], Pair(0, 1, 0, kMat), 6), 1);
  EXPECT_GE(MatchesOffPlane(features[0], features[1], Pair(0, 1, 0, kMat + kFigure), 6),
            kFigure * 3 / 4);
}

TEST(FlatPairs, AreThoseOfTheMatAlone) {
  const auto features = Photographs(3);
  const std::vector<Verified> pairs{{Pair(0, 1, 0, kMat + kFigure), {}}, {Pair(0, 2, 0, kMat), {}}};
  EXPECT_EQ(FlatPairs(features, {}, 1, pairs), (std::vector<char>{0, 1}));
}

}  // namespace keypose::reconstruct::flat_pairs_test
