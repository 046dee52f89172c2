// Recorded values of a theropod that walks.
#pragma once

#include <vector>

#include "armature/recording/joint_curves.h"
#include "armature/testing/theropods.h"

namespace keypose::armature {

inline JointCurves Walk(const Armature& theropod, int frames, int step) {
  JointCurves curves;
  curves.step = step;
  curves.values.resize(frames, static_cast<Eigen::Index>(theropod.joints.size()));
  const auto rows = Frames(theropod, frames);
  for (int f = 0; f < frames; ++f)
    curves.values.row(f) = Eigen::Map<const Eigen::RowVectorXd>(
        rows[f].data(), static_cast<Eigen::Index>(rows[f].size()));
  return curves;
}

}  // namespace keypose::armature
