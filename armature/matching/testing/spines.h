// Armatures and skeletons for tests and benchmarks.
#pragma once

#include <cstdint>
#include <vector>

#include "armature/description/armature.h"
#include "armature/matching/joint_skeleton.h"
#include "armature/matching/polyline.h"

namespace keypose::armature {

/// A row of rods along y, each behind a hinge about x or, every second, about z.
/// Anchors "near" and "far", with the computer's joints of the same names, and one chain.
struct Spine {
  Armature armature;
  ChainPlan plan;
};
Spine MakeSpine(const std::vector<double>& lengths);

/// Joints "near", "joint1", ..., "far" along y.
Skeleton MakeStraightSkeleton(const std::vector<double>& lengths);

/// A random physical chain of 14 rods and 9 rods for it, up to 6 % longer than the chain is.
struct RandomChain {
  PointsX3 curve;
  Eigen::VectorXd lengths;
};
std::vector<RandomChain> MakeRandomChains(int count, std::uint64_t seed);

/// Values of a spine's joints in a move of `seconds`: waves that pass along it, of at most
/// `degrees` for each joint; at a time.
std::vector<double> WaveAt(int joints, double degrees, double time_s);

}  // namespace keypose::armature
