#include "reconstruct/matching/pair_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/numbers/parallel.h"
#include "reconstruct/matching/testing/random_features.h"

namespace keypose::reconstruct::pair_list_test {

using ::testing::ElementsAre;

TEST(CircularPairs, CloseTheRing) {
  EXPECT_THAT(CircularPairs(5, 1), ElementsAre(ImagePair(0, 1), ImagePair(0, 4), ImagePair(1, 2),
                                               ImagePair(2, 3), ImagePair(3, 4)));
  EXPECT_EQ(CircularPairs(4, 3), AllPairs(4));
  EXPECT_TRUE(CircularPairs(1, 2).empty());
}

TEST(SimilarPairs, TakesTheBestOfEitherSideAndNeverZero) {
  Eigen::MatrixXi scores = Eigen::MatrixXi::Zero(4, 4);
  scores(0, 1) = scores(1, 0) = 5;
  scores(0, 2) = scores(2, 0) = 7;
  EXPECT_THAT(SimilarPairs(scores, 1), ElementsAre(ImagePair(0, 1), ImagePair(0, 2)));
}

/// Two rings of `per_ring` images: each shares features with its neighbours in the ring and with
/// the same azimuth of the other ring.
std::vector<Features> TwoRings(int per_ring, std::mt19937& random) {
  std::vector<Features> images;
  std::vector<Features> shared;
  for (int i = 0; i < 3 * per_ring; ++i) shared.push_back(RandomFeatures(30, random));
  const auto append = [](Features& to, const Features& from) {
    Features sum;
    sum.positions.resize(to.count() + from.count(), 2);
    sum.scales.resize(to.count() + from.count());
    sum.positions << to.positions, from.positions;
    sum.scales << to.scales, from.scales;
    sum.descriptors = to.descriptors;
    sum.descriptors.insert(sum.descriptors.end(), from.descriptors.begin(), from.descriptors.end());
    to = sum;
  };
  for (int ring = 0; ring < 2; ++ring)
    for (int i = 0; i < per_ring; ++i) {
      Features f = RandomFeatures(20, random);
      append(f, shared[ring * per_ring + i]);
      append(f, shared[ring * per_ring + (i + 1) % per_ring]);
      append(f, shared[2 * per_ring + i]);
      images.push_back(f);
    }
  return images;
}

TEST(ChoosePairs, ClosesEachRingAndTiesTheRingsOfAShuffledSet) {
  std::mt19937 random(13);
  constexpr int kPerRing = 12;
  const auto rings = TwoRings(kPerRing, random);
  const auto order = Shuffled(2 * kPerRing, random);
  std::vector<Features> images;
  std::vector<int> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    images.push_back(rings[order[k]]);
    place[order[k]] = static_cast<int>(k);
  }
  PairListOptions options;
  options.all_pairs_limit = 10;
  options.neighbors = 1;
  options.similar = 3;
  const auto pairs = ChoosePairs(images, options);
  EXPECT_LT(pairs.size(), 24U * 3U + 24U);
  const auto has = [&](int i, int j) {
    const int a = place[i], b = place[j];
    return std::binary_search(pairs.begin(), pairs.end(),
                              ImagePair(std::min(a, b), std::max(a, b)));
  };
  for (int i = 0; i < kPerRing; ++i) {
    EXPECT_TRUE(has(i, (i + 1) % kPerRing)) << i;
    EXPECT_TRUE(has(kPerRing + i, kPerRing + (i + 1) % kPerRing)) << i;
    EXPECT_TRUE(has(i, kPerRing + i)) << i;
  }
  SetThreadCount(3);
  EXPECT_EQ(ChoosePairs(images, options), pairs);
  SetThreadCount(0);
}

TEST(ChoosePairs, FewImagesGiveAllPairs) {
  EXPECT_EQ(ChoosePairs(std::vector<Features>(5), {}), AllPairs(5));
}

}  // namespace keypose::reconstruct::pair_list_test
