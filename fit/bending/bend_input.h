// What a template is bent by, and how.
#pragma once

#include <vector>

#include "views/placement/surface_features.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

struct BendView {
  PreparedView view;                  ///< with its camera's first estimate
  std::vector<FeatureMatch> matches;  ///< pixels of level 0, points of the template
};

struct BendOptions {
  int coarse_vertices = 500;   ///< of the level on which far motion is found
  int middle_vertices = 1700;  ///< of the next level
  double smoothing = 0.02;     ///< maps vary little within this distance, over the diagonal
  /// How firmly cameras stay where they start, relative to what their photographs say: 0 for
  /// estimates of single photographs, which are improved with the shape from the beginning; 0.2
  /// for those of a rig, which are improved by texture; 1000 and more: fixed
  double hold_cameras = 0;
  bool only_far = false;  ///< stop when limbs are near their places, before grey values
};

}  // namespace keypose::fit
