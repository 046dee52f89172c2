#include "armature/live/posed_puppet.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include "armature/live/testing/theropod_parts.h"
#include "armature/testing/theropods.h"

namespace keypose::armature::posed_puppet_test {

using Eigen::Vector3d;

TEST(PosedPuppet, TheropodWalksWithItsFeetWhereTheArmatureHasThem) {
  const PuppetParts parts = TheropodParts();
  EXPECT_NEAR(parts.world_from_armature.scale, 1, 0.02);
  PosedPuppet puppet(parts);
  for (double time = 0; time < 1.2; time += 0.05) {
    const auto values = TheropodWalk(parts.armature, time);
    puppet.Update(values);
    const auto frames = ForwardKinematics(parts.armature, values);
    for (const ChainState& chain : puppet.matcher().chains()) {
      const bool leg = chain.name.find("Leg") != std::string::npos;
      const double limit = leg ? 0.02 : 1e-9;  // legs are one to one, and a little shorter
      if (chain.name == "neck" || chain.name == "tail" || leg) {
        EXPECT_LT(chain.match.far_gap, limit * chain.chain_length) << chain.name;
      }
    }
    const Vector3d tip =
        parts.world_from_armature * frames[parts.armature.Find("tailRod9")].translation;
    EXPECT_LT((puppet.matcher().pose().joints.row(parts.skeleton.Find("TailTip")).transpose() - tip)
                  .norm(),
              1e-9);
  }
}

TEST(PosedPuppet, NothingMovesWhenNoValueChanged) {
  const PuppetParts parts = TheropodParts();
  PosedPuppet puppet(parts);
  const auto values = TheropodWalk(parts.armature, 0.3);
  puppet.Update(values);
  const PointsX3 before = puppet.points();
  puppet.Update(values);
  EXPECT_FALSE(puppet.matcher().moved());
  EXPECT_EQ(before, puppet.points());
}

TEST(PosedPuppet, MovingAPartGivesTheBitsOfMovingAll) {
  const PuppetParts parts = TheropodParts();
  PosedPuppet puppet(parts);
  auto values = TheropodWalk(parts.armature, 0.3);
  puppet.Update(values);
  for (const char* name : {"tailBend7", "leftKneeBend", "trunkSide6"}) {
    values[parts.armature.JointOf(parts.armature.Find(name))] += 0.2;
    puppet.Update(values);
    PointsX3 whole;
    Skin(parts.mesh.points, parts.weights, parts.skeleton.size())
        .Pose(puppet.matcher().pose().bones, &whole);
    EXPECT_EQ(puppet.points(), whole) << name;
  }
}

}  // namespace keypose::armature::posed_puppet_test
