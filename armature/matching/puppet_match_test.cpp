// A whole skeleton after a whole armature.
#include "armature/matching/puppet_match.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "armature/matching/testing/spines.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature::puppet_match_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;

std::vector<double> Uneven(int count, double total) {
  std::vector<double> lengths;
  double sum = 0;
  for (int i = 0; i < count; ++i) {
    lengths.push_back(0.8 + 0.1 * ((i * 7) % 5));
    sum += lengths.back();
  }
  for (double& length : lengths) length *= total / sum;
  return lengths;
}

/// Of bone b against the bone before it.
Quaterniond JointTurn(const SkeletonPose& pose, int b) {
  return b < 2 ? pose.bones[b].rotation
               : pose.bones[b - 1].rotation.conjugate() * pose.bones[b].rotation;
}

TEST(PuppetMatcher, SameChainGivesNoResidualAndTheEncodersAngles) {
  const auto lengths = Uneven(14, 10);
  const Spine spine = MakeSpine(lengths);
  const Skeleton skeleton = MakeStraightSkeleton(lengths);
  PuppetMatcher matcher(spine.armature, spine.plan, skeleton, {}, {});
  for (double time = 0; time < 10; time += 0.37) {
    const auto values = WaveAt(14, 20, time);
    const SkeletonPose& pose = matcher.Update(values);
    EXPECT_LT(matcher.chains()[0].match.mean_distance, 1e-12);
    EXPECT_LT(matcher.chains()[0].match.far_gap, 1e-12);
    for (int j = 0; j < 14; ++j) {
      const Vector3d axis = spine.armature.nodes[spine.armature.joints[j]].axis;
      const Quaterniond wanted(Eigen::AngleAxisd(values[j], axis));
      EXPECT_LT(JointTurn(pose, j + 1).angularDistance(wanted), 1e-9) << time << " " << j;
    }
  }
}

TEST(PuppetMatcher, TwistOfTheArmatureIsKept) {
  const std::vector<double> lengths = {1, 1, 1};
  Spine spine = MakeSpine(lengths);
  spine.armature.nodes[spine.armature.joints[1]].axis = Vector3d::UnitY();  // a swivel
  PuppetMatcher matcher(spine.armature, spine.plan, MakeStraightSkeleton(lengths), {}, {});
  const SkeletonPose& pose = matcher.Update({0, 1.2, 0});
  EXPECT_LT(
      JointTurn(pose, 2).angularDistance(Quaterniond(Eigen::AngleAxisd(1.2, Vector3d::UnitY()))),
      1e-12);
}

TEST(PuppetMatcher, SmallStepsOfTheEncodersMakeNoJointJump) {
  const Spine spine = MakeSpine(Uneven(14, 10));
  const Skeleton skeleton = MakeStraightSkeleton(Uneven(9, 10.3));
  PuppetMatcher matcher(spine.armature, spine.plan, skeleton, {}, {});
  const double step = 0.1 * kDegree;
  SkeletonPose before = matcher.Update(WaveAt(14, 25, 0));
  double worst = 0;
  int steps = 0;
  for (double time = 0; time < 10; time += 0.002) {
    auto values = WaveAt(14, 25, time);
    for (double& value : values) value = std::round(value / step) * step;
    const SkeletonPose& pose = matcher.Update(values);
    if (!matcher.moved()) continue;
    ++steps;
    for (int b = 1; b < skeleton.size(); ++b) {
      worst = std::max(worst, JointTurn(pose, b).angularDistance(JointTurn(before, b)));
      // The same rotation has two quaternions; the nearer one follows.
      ASSERT_GT(pose.bones[b].rotation.dot(before.bones[b].rotation), 0);
    }
    before = pose;
  }
  EXPECT_GT(steps, 3000);
  EXPECT_LT(worst, 0.5 * kDegree);
}

TEST(PuppetMatcher, MirroredArmatureGivesMirroredSkeleton) {
  const Spine spine = MakeSpine(Uneven(14, 10));
  const Skeleton skeleton = MakeStraightSkeleton(Uneven(9, 10.4));
  PuppetMatcher one(spine.armature, spine.plan, skeleton, {}, {}),
      other(spine.armature, spine.plan, skeleton, {}, {});
  for (double time = 1; time < 8; time += 0.5) {
    const auto values = WaveAt(14, 25, time);
    auto mirrored = values;  // at x = 0: turns about x stay, those about y and z are reversed
    for (std::size_t j = 1; j < mirrored.size(); j += 2) mirrored[j] *= -1;
    PointsX3 joints = one.Update(values).joints;
    joints.col(0) *= -1;
    EXPECT_LT((joints - other.Update(mirrored).joints).cwiseAbs().maxCoeff(), 1e-8);
  }
}

/// A trunk with two arms at its end, each arm a chain.
struct Fork {
  Armature armature;
  ChainPlan plan;
  Skeleton skeleton;

  int Add(NodeKind kind, int parent, const Vector3d& axis, double length = 0) {
    ArmatureNode node;
    node.name = "n" + std::to_string(armature.nodes.size());
    node.kind = kind, node.parent = parent, node.axis = axis, node.length = length;
    if (node.moves()) {
      node.sensor = SizeOf(armature.joints);
      armature.joints.push_back(SizeOf(armature.nodes));
    }
    armature.nodes.push_back(node);
    return SizeOf(armature.nodes) - 1;
  }
  int Limb(int parent, const Vector3d& axis) {
    for (int i = 0; i < 3; ++i)
      parent = Add(NodeKind::kRod, Add(NodeKind::kJoint, parent, Vector3d::UnitX()), axis, 1);
    return parent;
  }
  Fork() {
    const int base = Add(NodeKind::kGroup, -1, Vector3d::UnitY());
    const int top = Limb(base, Vector3d::UnitY());
    const int left = Limb(top, Vector3d(-1, 1, 0).normalized());
    const int right = Limb(top, Vector3d(1, 1, 0).normalized());
    plan.anchors = {{"base", base, "base", 1},
                    {"top", top, "top", 2},
                    {"l", left, "l3", 3},
                    {"r", right, "r3", 4}};
    plan.chains = {Between("trunk", 0, 1), Between("left", 1, 2), Between("right", 1, 3)};
    plan.chains[2].mode = ChainMode::kExact;
    Joint("base", -1, {0, 0, 0});
    const int middle = Joint("middle", 0, {0, 1.55, 0}), end = Joint("top", middle, {0, 3.1, 0});
    int l = end, r = end;
    for (int i = 1; i <= 3; ++i) {
      l = Joint("l" + std::to_string(i), l, skeleton.joints[l].rest + Vector3d(-0.71, 0.71, 0));
      r = Joint("r" + std::to_string(i), r, skeleton.joints[r].rest + Vector3d(0.71, 0.71, 0));
    }
    Joint("nail", r, skeleton.joints[r].rest + Vector3d(0.2, 0, 0));
  }
  int Joint(const std::string& name, int parent, const Vector3d& rest) {
    skeleton.joints.push_back({name, parent, rest});
    return skeleton.size() - 1;
  }
  Chain Between(const std::string& name, int from, int to) const {
    Chain chain;
    chain.name = name, chain.from = from, chain.to = to;
    chain.nodes = PathBetween(armature, plan.anchors[from].node, plan.anchors[to].node);
    return chain;
  }
};

TEST(PuppetMatcher, OnlyChainsThatMovedAreMatchedAgain) {
  const Fork fork;
  PuppetMatcher matcher(fork.armature, fork.plan, fork.skeleton, {}, {});
  std::vector<double> values(9, 0.1);
  matcher.Update(values);
  EXPECT_EQ(matcher.matched(), 3);
  const SkeletonPose before = matcher.pose();
  matcher.Update(values);
  EXPECT_EQ(matcher.matched(), 0);
  EXPECT_FALSE(matcher.moved());
  EXPECT_EQ(before.joints, matcher.pose().joints);
  values[4] = 0.3;  // in the left arm
  matcher.Update(values);
  EXPECT_EQ(matcher.matched(), 1);
  values[0] = 0.3;  // in the trunk, which carries both arms
  matcher.Update(values);
  EXPECT_EQ(matcher.matched(), 3);
}

TEST(PuppetMatcher, BonesStayJoinedAndOthersFollowTheirParents) {
  const Fork fork;
  PuppetMatcher matcher(fork.armature, fork.plan, fork.skeleton, {}, {});
  std::vector<double> values(9);
  for (int j = 0; j < 9; ++j) values[j] = 0.3 * std::sin(j + 1.0);
  const SkeletonPose& pose = matcher.Update(values);
  for (int j = 1; j < fork.skeleton.size(); ++j) {
    const SkeletonJoint& joint = fork.skeleton.joints[j];
    const Vector3d parent = fork.skeleton.joints[joint.parent].rest;
    EXPECT_LT((pose.bones[j] * joint.rest - pose.joints.row(j).transpose()).norm(), 1e-12);
    EXPECT_LT((pose.bones[j] * parent - pose.joints.row(joint.parent).transpose()).norm(), 1e-12);
  }
  const int nail = fork.skeleton.Find("nail"), r3 = fork.skeleton.Find("r3");
  EXPECT_LT(pose.bones[nail].rotation.angularDistance(pose.bones[r3].rotation), 1e-9);
}

TEST(PuppetMatcher, RestThatIsNotTheZeroPositionIsTurnedThere) {
  const std::vector<double> lengths = {1, 1, 1};
  const Spine spine = MakeSpine(lengths);
  Skeleton skeleton = MakeStraightSkeleton(lengths);
  for (SkeletonJoint& joint : skeleton.joints)  // at rest it leads along x
    joint.rest = Vector3d(joint.rest.y(), 0, 0);
  PuppetMatcher matcher(spine.armature, spine.plan, skeleton, {}, {});
  const SkeletonPose& pose = matcher.Update({0, 0, 0});
  EXPECT_LT((pose.joints.row(3) - Eigen::RowVector3d(0, 3, 0)).norm(), 1e-12);
  const Quaterniond quarter(Eigen::AngleAxisd(kPi / 2, Vector3d::UnitZ()));
  for (int b = 1; b < 4; ++b) EXPECT_LT(pose.bones[b].rotation.angularDistance(quarter), 1e-7);
}

TEST(PlacementOf, LengthsAgreeAndTheNearAnchorIsInPlace) {
  const Spine spine = MakeSpine({1, 1, 1});
  Skeleton skeleton = MakeStraightSkeleton({0.02, 0.02, 0.02});
  for (SkeletonJoint& joint : skeleton.joints)
    joint.rest = Vector3d(0.1, 0.2, 0.3 + joint.rest.y());
  const Similarity3 placement = PlacementOf(spine.armature, spine.plan, skeleton, true);
  EXPECT_NEAR(placement.scale, 0.02, 1e-15);
  EXPECT_LT((placement * Vector3d(0, 3, 0) - Vector3d(0.1, 0.2, 0.36)).norm(), 1e-15);
}

TEST(PuppetMatcher, SayWhatIsWrongWithAChain) {
  const auto message = [](Fork fork) -> std::string {
    try {
      PuppetMatcher(fork.armature, fork.plan, fork.skeleton, {}, {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  Fork missing;
  missing.plan.anchors[2].computer = "nowhere";
  EXPECT_NE(message(missing).find("no joint 'nowhere'"), std::string::npos);
  Fork crossed;
  crossed.plan.chains[2] = crossed.Between("again", 1, 2);
  EXPECT_NE(message(crossed).find("belongs to another chain"), std::string::npos);
  Fork uneven;
  uneven.plan.chains[0].mode = ChainMode::kExact;  // 3 rods, but 2 in the skeleton
  EXPECT_NE(message(uneven).find("3 rods in the armature and 2"), std::string::npos);
  Fork flat;
  flat.skeleton.joints[1].rest.setZero();
  EXPECT_NE(message(flat).find("are at one place"), std::string::npos);
  Fork twice;
  twice.plan.chains[0].computer = {"middle", "middle"};
  EXPECT_NE(message(twice).find("are the same"), std::string::npos);
}

TEST(PuppetMatcher, BadValuesThrowInputError) {
  const Fork fork;
  PuppetMatcher matcher(fork.armature, fork.plan, fork.skeleton, {}, {});
  EXPECT_THROW(matcher.Update({0, 0}), InputError);
  std::vector<double> values(9, 0);
  values[3] = std::nan("");
  EXPECT_THROW(matcher.Update(values), InputError);
}

}  // namespace keypose::armature::puppet_match_test
