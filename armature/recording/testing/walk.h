// Recorded values of a theropod that walks.
#pragma once

#include <vector>

#include "armature/example/theropod.h"
#include "armature/recording/joint_curves.h"

namespace keypose::armature {

inline JointCurves Walk(const Armature& theropod, int frames, int step) {
  JointCurves curves;
  curves.step = step;
  curves.values.resize(frames, static_cast<Eigen::Index>(theropod.joints.size()));
  for (int f = 0; f < frames; ++f) {
    const std::vector<double> values = TheropodWalk(theropod, f / 12.0);
    curves.values.row(f) = Eigen::Map<const Eigen::RowVectorXd>(
        values.data(), static_cast<Eigen::Index>(values.size()));
  }
  return curves;
}

inline std::vector<std::vector<double>> Frames(const Armature& theropod, int count) {
  std::vector<std::vector<double>> frames;
  for (int f = 0; f < count; ++f) frames.push_back(TheropodWalk(theropod, f / 12.0));
  return frames;
}

}  // namespace keypose::armature
