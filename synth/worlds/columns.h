// A figure with windows: a torso on columns.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "synth/worlds/clay.h"
#include "synth/worlds/limb_pose.h"
#include "synth/worlds/pose.h"

namespace keypose::synth {

/// A solid in its rest pose, named places on it, and its poses.
struct Character {
  Clay clay;
  std::vector<std::pair<std::string, Eigen::Vector3d>> places;
  std::vector<Pose> poses;
  std::vector<PosableLimb> limbs;  ///< for random poses; none: it has no such pose
};

/// A slab with four columns, and on them a torso with a head and one arm: asymmetric, genus 3. Seed
/// 1 has standard proportions; other seeds vary them. Poses: rest, bent, twist, squash.
Character SculptColumns(std::uint64_t seed);

}  // namespace keypose::synth
