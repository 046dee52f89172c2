// The generated theropod and its walk, for tests of the rooms that its own room is made of.
#pragma once

#include <vector>

#include "armature/example/theropod.h"

namespace keypose::armature {

/// Values of a walk, twelve frames a second.
inline std::vector<std::vector<double>> Frames(const Armature& theropod, int count) {
  std::vector<std::vector<double>> frames;
  for (int f = 0; f < count; ++f) frames.push_back(TheropodWalk(theropod, f / 12.0));
  return frames;
}

}  // namespace keypose::armature
