// Matching of descriptors, matching along epipolar lines, and the selection of pairs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <random>

#include "core/numbers/parallel.h"
#include "reconstruct/matching/descriptor_matching.h"
#include "reconstruct/matching/guided_matching.h"
#include "reconstruct/matching/pair_list.h"

namespace keypose::reconstruct::matching_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::ElementsAre;

constexpr double kPi = 3.14159265358979323846;

/// Random unit-512 descriptors, as SIFT's are: non-negative 8-bit numbers.
Features RandomFeatures(int count, std::mt19937& random) {
  Features features;
  features.positions.resize(count, 2);
  features.scales.resize(count);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int i = 0; i < count; ++i) {
    features.positions.row(i) << 640 * uniform(random), 480 * uniform(random);
    features.scales(i) = 1 + 10 * uniform(random);
    Eigen::VectorXd d(128);
    for (int k = 0; k < 128; ++k) d(k) = std::pow(uniform(random), 4);
    d *= 512 / d.norm();
    for (int k = 0; k < 128; ++k)
      features.descriptors.push_back(static_cast<std::int16_t>(std::min(255.0, std::round(d(k)))));
  }
  return features;
}

Features Permuted(const Features& features, const std::vector<int>& order) {
  Features out;
  out.positions.resize(std::ssize(order), 2);
  out.scales.resize(std::ssize(order));
  for (std::size_t i = 0; i < order.size(); ++i) {
    out.positions.row(i) = features.positions.row(order[i]);
    out.scales(static_cast<Eigen::Index>(i)) = features.scales(order[i]);
    const auto from = features.descriptors.begin() + static_cast<std::ptrdiff_t>(order[i]) * 128;
    out.descriptors.insert(out.descriptors.end(), from, from + 128);
  }
  return out;
}

std::vector<int> Shuffled(int count, std::mt19937& random) {
  std::vector<int> order(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) order[i] = i;
  for (int i = count - 1; i > 0; --i)
    std::swap(order[i], order[random() % static_cast<unsigned>(i + 1)]);
  return order;
}

/// The same search in floating point, pair by pair.
std::vector<std::pair<std::uint32_t, std::uint32_t>> MatchByDefinition(
    const Features& a, const Features& b, const MatchOptions& options) {
  Eigen::MatrixXd angles(a.count(), b.count());
  for (int i = 0; i < a.count(); ++i)
    for (int j = 0; j < b.count(); ++j) {
      double dot = 0;
      for (int k = 0; k < 128; ++k)
        dot += static_cast<double>(a.descriptors[static_cast<std::size_t>(i) * 128 + k]) *
               b.descriptors[static_cast<std::size_t>(j) * 128 + k];
      angles(i, j) = std::acos(std::min(1.0, dot / (512.0 * 512.0)));
    }
  const auto best = [&](const Eigen::VectorXd& row) {
    int at = 0;
    const double nearest = row.minCoeff(&at);
    double second = kPi / 2;
    for (int j = 0; j < row.size(); ++j)
      if (j != at) second = std::min(second, row(j));
    return nearest <= options.max_distance && nearest < options.max_ratio * second ? at : -1;
  };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> matches;
  for (int i = 0; i < a.count(); ++i)
    if (const int j = best(angles.row(i)); j >= 0 && best(angles.col(j)) == i)
      matches.emplace_back(i, j);
  return matches;
}

TEST(MatchDescriptors, FindsAPermutationExactly) {
  std::mt19937 random(5);
  const Features a = RandomFeatures(203, random);
  const auto order = Shuffled(203, random);
  const auto matches = MatchDescriptors(a, Permuted(a, order), {});
  ASSERT_EQ(matches.size(), 203U);
  for (const auto& [i, j] : matches) EXPECT_EQ(static_cast<int>(i), order[j]);
}

TEST(MatchDescriptors, AgreesWithTheDefinitionOnNoisyDescriptors) {
  std::mt19937 random(6);
  const Features a = RandomFeatures(151, random);
  Features b = Permuted(a, Shuffled(151, random));
  std::normal_distribution<double> noise(0, 14);
  for (std::int16_t& d : b.descriptors)
    d = static_cast<std::int16_t>(std::clamp(d + noise(random), 0.0, 255.0));
  const MatchOptions options;
  const auto expected = MatchByDefinition(a, b, options);
  EXPECT_GT(expected.size(), 20U);
  EXPECT_EQ(MatchDescriptors(a, b, options), expected);
}

TEST(MatchDescriptors, NoFeaturesGiveNoMatches) {
  std::mt19937 random(7);
  EXPECT_TRUE(MatchDescriptors(Features{}, RandomFeatures(5, random), {}).empty());
  EXPECT_TRUE(MatchDescriptors(RandomFeatures(5, random), Features{}, {}).empty());
}

TEST(LargestFeatures, KeepsTheLargestInTheirOrder) {
  std::mt19937 random(8);
  Features features = RandomFeatures(4, random);
  features.scales << 2, 9, 1, 5;
  EXPECT_EQ(LargestFeatures(features, 2).scales, Eigen::Vector2f(9, 5));
}

/// Two images with a baseline along x, so that epipolar lines are rows.
PairGeometry RowGeometry() {
  PairGeometry geometry;
  geometry.kind = PairGeometry::kFundamental;
  geometry.matrix << 0, 0, 0, 0, 0, -1, 0, 1, 0;
  return geometry;
}

TEST(MatchGuided, FindsOnTheLineWhatARivalElsewhereHides) {
  std::mt19937 random(9);
  Features a = RandomFeatures(1, random);
  a.positions.row(0) << 100, 200;
  // twice the same descriptor: the ratio test alone must reject it
  Features b = Permuted(a, {0, 0});
  b.positions.row(0) << 300, 201;
  b.positions.row(1) << 300, 260;
  EXPECT_TRUE(MatchDescriptors(a, b, {}).empty());
  EXPECT_THAT(MatchGuided(a, b, RowGeometry(), {}, 4),
              ElementsAre(std::pair<std::uint32_t, std::uint32_t>(0, 0)));
}

TEST(MatchGuided, TriesExactlyTheFeaturesWithinTheError) {
  std::mt19937 random(10);
  const Features a = RandomFeatures(300, random);
  Features b = Permuted(a, Shuffled(300, random));
  PairGeometry geometry;
  geometry.kind = PairGeometry::kFundamental;
  geometry.matrix << 1e-7, -3e-6, 2e-3, 2.6e-6, 2e-7, -2.2e-2, -2.4e-3, 2.1e-2, 1.1;
  const auto matches = MatchGuided(a, b, geometry, {.max_ratio = 1, .max_distance = 1.5}, 4);
  for (const auto& [i, j] : matches) {
    const Vector3d x = a.positions.row(i).transpose().cast<double>().homogeneous(),
                   y = b.positions.row(j).transpose().cast<double>().homogeneous();
    const Vector3d line = geometry.matrix * x;
    const double e2 = std::pow(y.dot(line), 2);
    EXPECT_LE(e2, 16 * (line.head<2>().squaredNorm() +
                        (geometry.matrix.transpose() * y).head<2>().squaredNorm()));
  }
  EXPECT_GT(matches.size(), 10U);
}

TEST(MatchGuided, GridMissesNothingNearSteepAndFlatLines) {
  std::mt19937 random(11);
  const Features a = RandomFeatures(120, random);
  for (const double angle : {0.0, 0.4, 0.8, 1.2, 1.57}) {
    // Features shifted along a direction: the geometry of a sideways camera, rotated.
    const Vector2d along(std::cos(angle), std::sin(angle));
    Features b = a;
    for (int i = 0; i < b.count(); ++i)
      b.positions.row(i) += (30 + i % 50) * along.cast<float>().transpose();
    PairGeometry geometry;
    geometry.kind = PairGeometry::kFundamental;
    geometry.matrix << 0, 0, along.y(), 0, 0, -along.x(), -along.y(), along.x(), 0;
    EXPECT_EQ(MatchGuided(a, b, geometry, {}, 4).size(), 120U) << angle;
  }
}

TEST(MatchGuided, HomographyLooksAroundTheTarget) {
  std::mt19937 random(12);
  Features a = RandomFeatures(1, random);
  a.positions.row(0) << 100, 100;
  Features b = Permuted(a, {0, 0});
  b.positions.row(0) << 110, 106;  // 1 px off the shifted position
  b.positions.row(1) << 140, 105;
  PairGeometry geometry;
  geometry.kind = PairGeometry::kHomography;
  geometry.matrix << 1, 0, 10, 0, 1, 5, 0, 0, 1;
  EXPECT_THAT(MatchGuided(a, b, geometry, {}, 4),
              ElementsAre(std::pair<std::uint32_t, std::uint32_t>(0, 0)));
}

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

}  // namespace keypose::reconstruct::matching_test
