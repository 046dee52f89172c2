// Models whose alignment is known exactly.
#include "reconstruct/join/model_alignment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::model_alignment_test {

using Eigen::Vector3d;
using ::testing::ElementsAre;
using testing::PointAt;

/// A cloud and its copy in another frame, with pairs of which a given share is wrong.
struct Halves {
  Scene first, second;
  std::vector<std::pair<int, int>> pairs;
  Similarity3 first_from_second;
};

Halves MakeHalves(int good, int wrong) {
  Halves halves;
  halves.first_from_second.scale = 1.7;
  halves.first_from_second.rotation =
      Eigen::AngleAxisd(1.6, Vector3d(1, -0.3, 0.2).normalized()).toRotationMatrix();
  halves.first_from_second.translation = Vector3d(0.3, -1, 2);
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0, 1);
  const Similarity3 back = halves.first_from_second.Inverse();
  for (int i = 0; i < good + wrong; ++i) {
    const Vector3d x(normal(random), normal(random), normal(random));
    const Vector3d other(normal(random), normal(random), normal(random));
    const Vector3d off = 1e-3 * Vector3d(normal(random), normal(random), normal(random));
    halves.first.points.push_back(PointAt(x));
    halves.second.points.push_back(PointAt(back * (i < good ? x + off : other)));
    halves.pairs.emplace_back(i, i);
  }
  return halves;
}

TEST(AlignModels, FindsTheSimilarityAmongMostlyWrongPairs) {
  const Halves halves = MakeHalves(60, 140);
  const ModelAlignment join = AlignModels(halves.first, halves.second, halves.pairs, {});
  ASSERT_TRUE(join.found);
  EXPECT_GE(join.agreeing, 60);
  EXPECT_LE(join.agreeing, 62);
  EXPECT_NEAR(join.first_from_second.scale, 1.7, 1e-3);
  EXPECT_LT((join.first_from_second.translation - halves.first_from_second.translation).norm(),
            2e-3);
  EXPECT_LT(join.rms, 0.003);
}

TEST(AlignModels, UnrelatedModelsAreNotJoined) {
  const Halves halves = MakeHalves(0, 200);
  EXPECT_FALSE(AlignModels(halves.first, halves.second, halves.pairs, {}).found);
  EXPECT_FALSE(AlignModels(halves.first, halves.second, {}, {}).found);
}

TEST(MatchPoints, MostVotesWinAndNoPointIsUsedTwice) {
  // Images 0 (features 0, 1) and 1 (features 5, 6) see points 0 and 1 of the first model; images 2
  // and 3 see those of the second.
  const std::vector<TrackElement> first = {{0, 0, 0}, {1, 5, 0}, {0, 1, 1}, {1, 6, 1}},
                                  second = {{2, 7, 0}, {3, 8, 0}, {2, 9, 1}};
  const std::vector<PairMatches> matches = {
      {0, 2, {{0, 7}, {1, 9}}}, {1, 3, {{5, 8}}}, {1, 2, {{6, 7}}}};
  EXPECT_THAT(MatchPoints(first, second, matches), ElementsAre(std::pair(0, 0), std::pair(1, 1)));
}

}  // namespace keypose::reconstruct::model_alignment_test
