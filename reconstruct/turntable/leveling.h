// Transforms a reconstruction of a turntable capture into a canonical frame.
#pragma once

#include <vector>

#include "core/values/camera.h"

namespace keypose::reconstruct {

struct Leveling {
  Similarity3 level_from_model;
  int rings = 0;  ///< groups of cameras related by rotations about the axis
  /// distance of the rings' cameras from their planes, over the mean camera distance
  double plane_rms = 0;
  double circle_rms = 0;  ///< distance of the rings' cameras from circles about the common axis,
                          ///< over the mean camera distance
  std::vector<int> ring_of_view;  ///< -1 for views of no ring
  bool centered_on_axis = false;  ///< else on the centre of the object's points
};

/// The frame: z along the turntable's axis, up as the cameras see it; the lowest object point (1 %
/// quantile) at z = 0; the axis (or the object's centre, if the cameras form no rings about one
/// axis) at x = y = 0; the first camera in direction -y; mean camera distance to the object's
/// centre 1.
///
/// Cameras of one ring of a turntable (or of a walk around the object) differ by rotations about
/// its axis, for any roll and elevation and any number of missing positions. The axis is the
/// densest direction among the axes of all pairs' relative rotations; the rings' planes then refine
/// it.
/// @throws InputError  fewer than 3 views or fewer than 10 points, or all cameras in one place
Leveling LevelScene(const Scene& scene);

}  // namespace keypose::reconstruct
