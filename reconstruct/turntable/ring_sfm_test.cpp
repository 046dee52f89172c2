#include "reconstruct/turntable/ring_sfm.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/values/size_of.h"
#include "reconstruct/turntable/testing/ring_world.h"

namespace keypose::reconstruct::ring_sfm_test {

using Eigen::Vector3d;
using ::testing::HasSubstr;

/// Features whose descriptors identify the points, and their true matches except those that `each`
/// leaves out.
struct FeatureSet {
  std::vector<Features> features;
  std::vector<PairMatches> matches;
};

FeatureSet MakeFeatures(RingWorld& world, double noise) {
  FeatureSet set;
  std::vector<std::vector<std::int16_t>> descriptors(world.points.size());
  for (auto& d : descriptors) {
    Eigen::VectorXd v(128);
    for (int k = 0; k < 128; ++k)
      v(k) = std::pow(std::uniform_real_distribution<double>(0, 1)(world.random), 4);
    v *= 512 / v.norm();
    for (int k = 0; k < 128; ++k)
      d.push_back(static_cast<std::int16_t>(std::min(255.0, std::round(v(k)))));
  }
  for (std::size_t v = 0; v < world.truth.views.size(); ++v) {
    std::vector<std::size_t> seen;
    for (std::size_t p = 0; p < world.points.size(); ++p)
      if (world.Sees(v, p)) seen.push_back(p);
    Features f;
    f.positions.resize(std::ssize(seen), 2);
    f.scales = Eigen::VectorXf::Ones(std::ssize(seen));
    for (std::size_t k = 0; k < seen.size(); ++k) {
      f.positions.row(k) = world.Pixel(v, seen[k], noise).transpose().cast<float>();
      f.descriptors.insert(f.descriptors.end(), descriptors[seen[k]].begin(),
                           descriptors[seen[k]].end());
    }
    set.features.push_back(std::move(f));
  }
  // The matches for the ring's start: a few of each pair.
  for (int a = 0; a < std::ssize(set.features); ++a)
    for (int b = a + 1; b < std::ssize(set.features); ++b) {
      PairMatches pair{a, b, MatchDescriptors(set.features[a], set.features[b], {})};
      if (pair.features.size() > 9) pair.features.resize(9);
      if (!pair.features.empty()) set.matches.push_back(std::move(pair));
    }
  return set;
}

TEST(ReconstructRing, ClosesWithFiveViewsMissing) {
  RingWorld world = MakeWorld({25}, 24, 120, 0.2);
  for (const int gone : {19, 12, 11, 6, 2}) {
    world.truth.views.erase(world.truth.views.begin() + gone);
    world.names.erase(world.names.begin() + gone);
  }
  for (std::size_t v = 0; v < world.truth.views.size(); ++v)
    world.truth.views[v].image = static_cast<int>(v);
  const FeatureSet set = MakeFeatures(world, 0.3);
  const RingSfmResult ring = ReconstructRing(world.truth.camera, world.names, set.features,
                                             set.matches, LikelyLayouts(world.names), {});
  ASSERT_TRUE(ring.found);
  EXPECT_THAT(ring.layout.reason, HasSubstr("1 ring of 24"));
  EXPECT_EQ(ring.scene.views.size(), 19U);
  EXPECT_LT(CenterError(Centers(ring.scene), Centers(world.truth)), 1e-3);
  EXPECT_FALSE(ring.freed);
}

TEST(ReconstructRing, CamerasThatStandOffTheRingAreSetFree) {
  RingWorld world = MakeWorld({25}, 16, 150, 0.2);
  const FeatureSet even = MakeFeatures(world, 0.3);
  EXPECT_FALSE(ReconstructRing(world.truth.camera, world.names, even.features, even.matches,
                               LikelyLayouts(world.names), {})
                   .freed);
  // Held in the hand: for the projection, each view has a ring of its own.
  RingWorld shaky = world;
  shaky.truth.rings.clear();
  for (RingView& view : shaky.truth.views) {
    Rigid3 pose = world.truth.rings[0];
    pose.translation += 0.012 * Vector3d(world.Gauss(1), world.Gauss(1), world.Gauss(1));
    view.ring = SizeOf(shaky.truth.rings);
    shaky.truth.rings.push_back(pose);
  }
  const FeatureSet set = MakeFeatures(shaky, 0.3);
  const RingSfmResult ring = ReconstructRing(world.truth.camera, world.names, set.features,
                                             set.matches, LikelyLayouts(world.names), {});
  ASSERT_TRUE(ring.found);
  EXPECT_TRUE(ring.freed);
  EXPECT_LT(ring.chi2_ratio, 0.5);
  // Some 50 points per view at 0.3 px, with free focal length and distortion.
  EXPECT_LT(CenterError(Centers(ring.scene), Centers(shaky.truth)), 6e-3);
}

}  // namespace keypose::reconstruct::ring_sfm_test
