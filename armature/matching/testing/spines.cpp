#include "armature/matching/testing/spines.h"

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <string>

#include "core/values/angles.h"
#include "core/values/size_of.h"

namespace keypose::armature {

using Eigen::Vector3d;

Spine MakeSpine(const std::vector<double>& lengths) {
  Spine spine;
  Armature& armature = spine.armature;
  armature.nodes.push_back({});
  armature.nodes.back().name = "base";
  for (int i = 0; i < SizeOf(lengths); ++i) {
    ArmatureNode joint, rod;
    joint.name = "bend" + std::to_string(i);
    joint.kind = NodeKind::kJoint;
    joint.axis = i % 2 ? Vector3d::UnitZ() : Vector3d::UnitX();
    joint.parent = SizeOf(armature.nodes) - 1;
    joint.sensor = i;
    armature.joints.push_back(SizeOf(armature.nodes));
    armature.nodes.push_back(joint);
    rod.name = "rod" + std::to_string(i);
    rod.kind = NodeKind::kRod;
    rod.length = lengths[i];
    rod.parent = SizeOf(armature.nodes) - 1;
    armature.nodes.push_back(rod);
  }
  const int last = SizeOf(armature.nodes) - 1;
  spine.plan.anchors = {{"near", 0, "near", 1}, {"far", last, "far", 2}};
  Chain chain;
  chain.name = "spine";
  chain.from = 0, chain.to = 1;
  chain.nodes = PathBetween(armature, 0, last);
  spine.plan.chains = {chain};
  return spine;
}

Skeleton MakeStraightSkeleton(const std::vector<double>& lengths) {
  Skeleton skeleton;
  skeleton.joints.push_back({"near", -1, Vector3d::Zero()});
  double at = 0;
  for (int i = 0; i < SizeOf(lengths); ++i) {
    at += lengths[i];
    const bool last = i + 1 == SizeOf(lengths);
    skeleton.joints.push_back(
        {last ? "far" : "joint" + std::to_string(i + 1), i, Vector3d(0, at, 0)});
  }
  return skeleton;
}

std::vector<RandomChain> MakeRandomChains(int count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  // The library's distributions differ between compilers.
  const auto share = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  const auto any = [&] {
    const double z = 2 * share() - 1, angle = 2 * kPi * share(), r = std::sqrt(1 - z * z);
    return Vector3d(r * std::cos(angle), r * std::sin(angle), z);
  };
  constexpr int kPhysical = 14, kComputer = 9;
  std::vector<RandomChain> chains;
  for (int c = 0; c < count; ++c) {
    RandomChain chain;
    chain.curve.setZero(kPhysical + 1, 3);
    Vector3d direction = any(), axis = any();
    for (int p = 0; p < kPhysical; ++p) {
      axis = (axis + 0.8 * any()).normalized();
      direction = Eigen::AngleAxisd(0.6 * share(), axis) * direction;
      chain.curve.row(p + 1) = chain.curve.row(p) + (0.5 + share()) * direction.transpose();
    }
    chain.lengths.resize(kComputer);
    for (int i = 0; i < kComputer; ++i) chain.lengths[i] = 0.5 + share();
    const double longer = 1 + 0.06 * share();
    chain.lengths *= Polyline(chain.curve).length() * longer / chain.lengths.sum();
    chains.push_back(chain);
  }
  return chains;
}

std::vector<double> WaveAt(int joints, double degrees, double time_s) {
  std::vector<double> values(joints);
  for (int j = 0; j < joints; ++j)
    values[j] = degrees * kDegree * std::sin(0.6 * time_s + 0.35 * j) *
                (j % 2 ? std::cos(0.23 * time_s) : 1);
  return values;
}

}  // namespace keypose::armature
