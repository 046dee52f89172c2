#include "armature/description/armature.h"

#include <gtest/gtest.h>

#include "armature/testing/theropods.h"

namespace keypose::armature::armature_test {

ArmatureNode Node(const std::string& name, int parent, NodeKind kind, const Eigen::Vector3d& axis,
                  double length = 0) {
  ArmatureNode node;
  node.name = name;
  node.parent = parent;
  node.kind = kind;
  node.axis = axis;
  node.length = length;
  return node;
}

Armature TwoLinks() {
  Armature made;
  made.nodes = {Node("shoulder", -1, NodeKind::kJoint, Eigen::Vector3d::UnitZ()),
                Node("upper", 0, NodeKind::kRod, Eigen::Vector3d::UnitX(), 2),
                Node("elbow", 1, NodeKind::kJoint, Eigen::Vector3d::UnitZ()),
                Node("lower", 2, NodeKind::kRod, Eigen::Vector3d::UnitX(), 1)};
  made.joints = {0, 2};
  return made;
}

TEST(ForwardKinematics, PlanarTwoLinksFollowTheirClosedForm) {
  const Armature arm = TwoLinks();
  for (const double a : {0.0, 0.3, -1.2, 2.9})
    for (const double b : {0.0, 1.1, -2.5}) {
      const auto frames = ForwardKinematics(arm, {a, b});
      const Eigen::Vector3d elbow(2 * std::cos(a), 2 * std::sin(a), 0);
      const Eigen::Vector3d hand = elbow + Eigen::Vector3d(std::cos(a + b), std::sin(a + b), 0);
      EXPECT_LT((frames[2].translation - elbow).norm(), 1e-15);
      EXPECT_LT((frames[3].translation - hand).norm(), 1e-15);
      EXPECT_LT(frames[3].rotation.angularDistance(
                    Eigen::Quaterniond(Eigen::AngleAxisd(a + b, Eigen::Vector3d::UnitZ()))),
                1e-7);
    }
}

TEST(ForwardKinematics, SlideMovesAllThatHangsBelow) {
  Armature arm = TwoLinks();
  for (ArmatureNode& node : arm.nodes) ++node.parent;
  arm.nodes.insert(arm.nodes.begin(), Node("rig", -1, NodeKind::kSlide, Eigen::Vector3d::UnitZ()));
  arm.joints = {0, 1, 3};
  const auto frames = ForwardKinematics(arm, {0.25, 0, 0});
  EXPECT_EQ(frames[4].translation, Eigen::Vector3d(3, 0, 0.25));
}

TEST(ForwardKinematics, ZeroPositionOfTheTheropodIsStraight) {
  const Armature theropod = MakeTheropod();
  const auto frames = ForwardKinematics(theropod, std::vector<double>(theropod.joints.size()));
  for (const Rigid3& frame : frames) EXPECT_EQ(frame.rotation.w(), 1);
  const auto at = [&](const std::string& name) {
    return frames[static_cast<std::size_t>(theropod.Find(name))].translation;
  };
  EXPECT_EQ(at("skull").z(), at("tailRod9").z());
  EXPECT_NEAR(at("skull").y() - at("tailRod9").y(), 0.9, 0.02);  // three feet
  EXPECT_NEAR(at("leftToes").z(), 0.02, 1e-12);
}

TEST(PathBetween, GoesUpAndDownTheTree) {
  const Armature theropod = MakeTheropod();
  const int left = theropod.Find("leftHipBar"), right = theropod.Find("rightHipBar");
  EXPECT_EQ(PathBetween(theropod, left, right),
            (std::vector<int>{left, theropod.Find("pelvis"), right}));
  EXPECT_EQ(PathBetween(theropod, left, left), std::vector<int>{left});
}

TEST(PathBetween, IsEmptyBetweenTrees) {
  Armature two = TwoLinks();
  two.nodes[2].parent = -1;
  EXPECT_TRUE(PathBetween(two, 1, 3).empty());
}

TEST(ChainsMovedBy, NamesOnlyChainsBelowTheJoint) {
  const Armature theropod = MakeTheropod();
  const ChainPlan plan = MakeTheropodChains(theropod);
  const auto moved = ChainsMovedBy(theropod, plan);
  const auto chains_of = [&](const std::string& name) {
    std::vector<std::string> names;
    for (const int c : moved[theropod.JointOf(theropod.Find(name))])
      names.push_back(plan.chains[c].name);
    return names;
  };
  EXPECT_EQ(chains_of("tailBend3"), std::vector<std::string>{"tail"});
  EXPECT_EQ(chains_of("leftKneeBend"), std::vector<std::string>{"leftLeg"});
  EXPECT_EQ(chains_of("trunkBend2").size(), 3u);  // neck and both arms
  EXPECT_EQ(chains_of("rigLift").size(), 6u);
}

}  // namespace keypose::armature::armature_test
