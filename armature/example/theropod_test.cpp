#include "armature/example/theropod.h"

#include <gtest/gtest.h>

#include "armature/description/armature.h"

namespace keypose::armature::theropod_test {

TEST(Theropod, HasTheSensorsOfThePapersLargestAndSixChains) {
  const Armature theropod = MakeTheropod();
  EXPECT_EQ(theropod.joints.size(), 74u);
  EXPECT_EQ(theropod.sensor_count(), 74);
  EXPECT_EQ(MakeTheropodChains(theropod).chains.size(), 6u);
}

TEST(Theropod, AllJointsMoveInEachFrameOfTheWalk) {
  const Armature theropod = MakeTheropod();
  const auto before = TheropodWalk(theropod, 0), after = TheropodWalk(theropod, 1.0 / 12);
  for (std::size_t j = 0; j < before.size(); ++j)
    EXPECT_GT(std::abs(after[j] - before[j]), 1e-4) << theropod.nodes[theropod.joints[j]].name;
}

TEST(Theropod, ComputerSkeletonMeetsTheLegsAndNotTheNeck) {
  const Armature theropod = MakeTheropod();
  const ChainPlan plan = MakeTheropodChains(theropod);
  const MotionClip skeleton = MakeTheropodSkeleton();
  const auto nodes = ForwardKinematics(theropod, std::vector<double>(theropod.joints.size()));
  const auto joints = JointFrames(skeleton, 0);
  for (const Chain& chain : plan.chains) {
    if (chain.mode != ChainMode::kExact) continue;
    ASSERT_EQ(chain.computer.size() + 2, chain.nodes.size());
    for (std::size_t i = 0; i < chain.computer.size(); ++i) {
      const Eigen::Vector3d gap = joints[skeleton.Find(chain.computer[i])].translation -
                                  nodes[chain.nodes[i + 1]].translation;
      if (chain.name.ends_with("Leg")) {
        EXPECT_LT(gap.norm(), 1e-12) << chain.computer[i];
      }
    }
  }
  EXPECT_GT(
      (joints[skeleton.Find("HeadTip")].translation - nodes[theropod.Find("skull")].translation)
          .norm(),
      1e-3);
}

}  // namespace keypose::armature::theropod_test
