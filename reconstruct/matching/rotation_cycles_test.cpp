#include "reconstruct/matching/rotation_cycles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::rotation_cycles_test {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int kPhotographs = 24;

double Degrees(double radians) { return radians * 180 / 3.14159265358979; }

std::vector<View> Ring() {
  std::vector<View> views;
  for (int k = 0; k < kPhotographs; ++k) views.push_back(testing::BallCamera(k, kPhotographs, 2));
  return views;
}

PairRotation True(const std::vector<View>& views, int i, int j, double error_deg,
                  std::mt19937& random) {
  std::normal_distribution<double> gauss(0, 1);
  const Vector3d axis = Vector3d(gauss(random), gauss(random), gauss(random)).normalized();
  const Quaterniond error(AngleAxisd(error_deg / 57.2958 * gauss(random), axis));
  return {
      i, j,
      error * views[j].camera_from_world.rotation * views[i].camera_from_world.rotation.conjugate(),
      50};
}

// Neighbours up to three apart match rightly, with a degree of error; as many pairs farther apart
// look as if the camera hardly turned, and have more matches.
TEST(RotationCycles, TurnsOfARepeatingMatAreContradicted) {
  std::mt19937 random(1);
  const std::vector<View> views = Ring();
  std::vector<PairRotation> pairs;
  for (int i = 0; i < kPhotographs; ++i)
    for (int step = 1; step <= 3; ++step) {
      const int j = (i + step) % kPhotographs;
      pairs.push_back(True(views, std::min(i, j), std::max(i, j), 1, random));
    }
  const std::size_t right = pairs.size();
  std::uniform_int_distribution<int> any(0, kPhotographs - 1);
  while (pairs.size() < right + 36) {
    const int i = any(random), j = any(random);
    const int apart =
        std::min((i - j + kPhotographs) % kPhotographs, (j - i + kPhotographs) % kPhotographs);
    if (i >= j || apart < 5) continue;
    const Quaterniond hardly(AngleAxisd(0.05, Vector3d::UnitY()));
    pairs.push_back({i, j, hardly, 150, false});
  }
  const std::vector<char> agree = AgreeInRotation(kPhotographs, pairs, {});
  EXPECT_EQ(std::count(agree.begin(), agree.begin() + right, 1), right);
  EXPECT_EQ(std::count(agree.begin() + right, agree.end(), 1), 0);
}

TEST(RotationCycles, FlatPairsCountOnlyWhereTheyAreNeeded) {
  std::mt19937 random(4);
  const std::vector<View> views = Ring();
  std::vector<PairRotation> pairs;
  for (int i = 0; i + 1 < kPhotographs; ++i)
    if (i != 11) pairs.push_back(True(views, i, i + 1, 1, random));
  const std::size_t right = pairs.size();
  pairs.push_back(True(views, 11, 12, 1, random));  // nothing else joins the two halves
  pairs.push_back(True(views, 0, 2, 1, random));    // not needed
  pairs[right].flat = pairs[right + 1].flat = true;
  const std::vector<char> agree = AgreeInRotation(kPhotographs, pairs, {});
  EXPECT_EQ(std::count(agree.begin(), agree.begin() + right + 1, 1), right + 1);
  EXPECT_EQ(agree[right + 1], 0);
}

TEST(RotationCycles, TreesAreNotJudged) {
  std::mt19937 random(2);
  const std::vector<View> views = Ring();
  std::vector<PairRotation> pairs;
  for (int i = 0; i + 1 < kPhotographs; ++i) pairs.push_back(True(views, i, i + 1, 5, random));
  const std::vector<char> agree = AgreeInRotation(kPhotographs, pairs, {});
  EXPECT_EQ(std::count(agree.begin(), agree.end(), 1), kPhotographs - 1);
}

TEST(RotationCycles, RotationOfMatchesIsThatOfTheCameras) {
  const std::vector<View> views = Ring();
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-0.6, 0.6);
  std::normal_distribution<double> pixel(0, 0.2);
  Features features[2];
  PairMatches pair{0, 2, {}};
  constexpr int points = 60;
  for (Features& f : features) {
    f.positions.resize(points, 2);
    f.scales = Eigen::VectorXf::Constant(points, 2);
  }
  for (int p = 0; p < points; ++p) {
    const Vector3d x(unit(random), unit(random), unit(random));
    for (int side = 0; side < 2; ++side)
      features[side].positions.row(p) =
          (views[2 * side].Project(x) + Eigen::Vector2d(pixel(random), pixel(random)))
              .transpose()
              .cast<float>();
    pair.features.emplace_back(p, p);
  }
  const auto found =
      RotationOf(features[0], features[1], views[0].camera, views[2].camera, pair, 4);
  ASSERT_TRUE(found);
  std::mt19937 none(1);
  EXPECT_LT(Degrees(found->rotation.angularDistance(True(views, 0, 2, 0, none).rotation)), 2);
}

}  // namespace keypose::reconstruct::rotation_cycles_test
