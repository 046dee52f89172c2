// A figure that one sees through: a torso on columns.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "synth/clay.h"
#include "synth/pose.h"

namespace keypose::synth {

/// A solid in its rest pose, named places on it, and the poses that it takes.
struct Character {
  Clay clay;
  std::vector<std::pair<std::string, Eigen::Vector3d>> places;
  std::vector<Pose> poses;
};

/// A slab, four columns on it, and a torso with a head and one arm on top of them: lopsided, of
/// genus 3. Seed 1 has the plain proportions, others vary them. Poses: rest, bent, twist, squash.
Character SculptColumns(std::uint64_t seed);

}  // namespace keypose::synth
