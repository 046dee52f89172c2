// Photographs with outlier colours are detected, without loss of quality in the texture.
#include "texture/bake/colour_consensus.h"

#include <gtest/gtest.h>

#include "texture/bake/testing_spheres.h"

namespace keypose::texture::colour_consensus_test {

constexpr int kSize = 160;

/// The lamp is on one side of the camera and moves with it: right for 1, left for -1.
Paint Lit(double side) {
  return [side](const Vector3d& x, const Vector3d& eye) {
    const Vector3d out = eye.normalized(), right = Vector3d::UnitZ().cross(out).normalized();
    const double facing = std::max(
        0.0, x.normalized().dot((out + 1.2 * side * right + Vector3d(0, 0, 0.5)).normalized()));
    return (Smooth(x, eye) * static_cast<float>(0.35 + 0.65 * facing)).eval();
  };
}

struct Set {
  Mesh mesh = PatchSphere(10);
  std::vector<View> views = AllRound(kSize);
  std::vector<Photograph> photographs;
};

Set LitSet() {
  static const Set lit = [] {
    Set set;
    set.photographs = Shoot(set.mesh, set.views, Lit(-1));
    return set;
  }();
  return lit;
}

/// A green disc over a part of the figure, like a hand.
void Cover(Photograph& photograph) {
  const int cx = photograph.image.width / 2 + kSize / 10, cy = photograph.image.height / 2;
  for (int y = 0; y < photograph.image.height; ++y)
    for (int x = 0; x < photograph.image.width; ++x) {
      if (std::hypot(x - cx, y - cy) > 0.14 * kSize) continue;
      const std::uint8_t green[3] = {40, 170, 60};
      std::copy_n(green, 3, photograph.image.at(x, y));
    }
}

BakeOptions Quick() {
  BakeOptions options = Small();
  options.hold_out = 0;
  return options;
}

TEST(JudgeColors, PhotographsOfOneFigureUnderOneLampAreAllBelieved) {
  const Set set = LitSet();
  const BakeResult result = BakeAll(set.mesh, set.views, set.photographs, Quick());
  for (const ViewColors& colors : result.colors) {
    EXPECT_FALSE(colors.distrusted);
    EXPECT_FALSE(colors.other_light);
    EXPECT_TRUE(colors.hidden.empty());
    EXPECT_FALSE(colors.told);
    EXPECT_LT(colors.contrary, 0.02);
  }
}

TEST(JudgeColors, WhatCoversTheFigureInOnePhotographIsFoundAndNotPainted) {
  Set set;
  set.photographs = Shoot(set.mesh, set.views, Smooth);
  Cover(set.photographs[3]);
  const BakeResult covered = BakeAll(set.mesh, set.views, set.photographs, Quick());
  for (std::size_t v = 0; v < set.views.size(); ++v)
    EXPECT_EQ(covered.colors[v].hidden.empty(), v != 3) << v;
  EXPECT_FALSE(covered.colors[3].distrusted);
  EXPECT_TRUE(covered.colors[3].told);
  // 51 dB without the disc; one of the views that showed the place is gone, and the squares leave
  // some of the disc's border in the samples.
  EXPECT_GT(PsnrAgainst(set.mesh, covered.texture, Smooth), 45);
}

TEST(JudgeColors, PhotographOfSomethingElseIsNotBelievedAtAll) {
  Set set = LitSet();
  const std::vector<Photograph> strange =
      Shoot(set.mesh, {set.views[5]}, [](const Vector3d& x, const Vector3d&) {
        return Vector3f(0.1f, 0.5f + 0.2f * static_cast<float>(std::sin(9 * x.x())), 0.6f);
      });
  set.photographs[5] = strange[0];
  const BakeResult result = BakeAll(set.mesh, set.views, set.photographs, Quick());
  for (std::size_t v = 0; v < set.views.size(); ++v)
    EXPECT_EQ(result.colors[v].distrusted, v == 5) << v;
  EXPECT_FALSE(result.quality[5].used);
}

TEST(JudgeColors, PhotographsAfterTheLampFellAreTheFewThatAreLitFromTheOtherSide) {
  Set set = LitSet();
  const std::vector<View> late(set.views.begin() + 13, set.views.begin() + 16);
  std::vector<Photograph> fallen = Shoot(set.mesh, late, Lit(1));
  std::move(fallen.begin(), fallen.end(), set.photographs.begin() + 13);
  const BakeResult result = BakeAll(set.mesh, set.views, set.photographs, Quick());
  // The last two view along the axis: the side of their lamp is not comparable with the others'.
  for (std::size_t v = 0; v < 16; ++v) {
    EXPECT_EQ(result.colors[v].other_light, v >= 13)
        << v << " " << result.colors[v].light.transpose();
    EXPECT_FALSE(result.colors[v].distrusted) << v;
  }
}

TEST(JudgeColors, SameBitsForAnyThreadCount) {
  Set set = LitSet();
  Cover(set.photographs[3]);
  SetThreadCount(1);
  const BakeResult one = BakeAll(set.mesh, set.views, set.photographs, Quick());
  SetThreadCount(4);
  const BakeResult four = BakeAll(set.mesh, set.views, set.photographs, Quick());
  SetThreadCount(0);
  EXPECT_EQ(one.texture.data, four.texture.data);
  for (std::size_t v = 0; v < set.views.size(); ++v)
    EXPECT_EQ(one.colors[v].contrary, four.colors[v].contrary);
}

}  // namespace keypose::texture::colour_consensus_test
