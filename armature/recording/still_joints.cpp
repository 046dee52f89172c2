#include "armature/recording/still_joints.h"

namespace keypose::armature {
namespace {

constexpr std::size_t kFrames = 3;

/// For each joint the nearest joint above it, or -1.
std::vector<int> JointsAbove(const Armature& armature) {
  std::vector<int> above;
  for (int node : armature.joints) {
    node = armature.nodes[static_cast<std::size_t>(node)].parent;
    while (node >= 0 && armature.JointOf(node) < 0)
      node = armature.nodes[static_cast<std::size_t>(node)].parent;
    above.push_back(node < 0 ? -1 : armature.JointOf(node));
  }
  return above;
}

/// Whether a joint changed with each of `count` frames that end at frame `last`, or with none.
bool Moved(const std::vector<std::vector<double>>& frames, std::size_t last, std::size_t joint,
           bool moved) {
  for (std::size_t f = last + 1 - kFrames; f <= last; ++f)
    if ((frames[f][joint] != frames[f - 1][joint]) != moved) return false;
  return true;
}

}  // namespace

std::vector<int> StillJoints(const Armature& armature,
                             const std::vector<std::vector<double>>& frames) {
  std::vector<int> still;
  if (frames.size() < 2 * kFrames + 1) return still;
  const std::size_t last = frames.size() - 1;
  const std::vector<int> above = JointsAbove(armature);
  std::vector<bool> has_moving_neighbour(above.size());
  for (std::size_t j = 0; j < above.size(); ++j) {
    if (above[j] < 0) continue;
    const auto other = static_cast<std::size_t>(above[j]);
    if (Moved(frames, last, other, true)) has_moving_neighbour[j] = true;
    if (Moved(frames, last, j, true)) has_moving_neighbour[other] = true;
  }
  for (std::size_t j = 0; j < above.size(); ++j)
    if (has_moving_neighbour[j] && Moved(frames, last, j, false) &&
        Moved(frames, last - kFrames, j, true))
      still.push_back(static_cast<int>(j));
  return still;
}

std::string StillWords(const std::string& joint, int since) {
  return joint +
         " has not moved by a count in three frames, though the joint beside it has: is its "
         "encoder stuck? Mend it, put the joint to its zero, type `zero " +
         joint + "`, and `goto " + std::to_string(since) + "` to take these frames again";
}

}  // namespace keypose::armature
