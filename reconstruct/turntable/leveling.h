// Brings a reconstruction of a turntable capture into a canonical frame.
#pragma once

#include <vector>

#include "core/camera.h"

namespace keypose::reconstruct {

struct Leveling {
  Similarity3 level_from_model;
  int rings = 0;          ///< groups of cameras that turn about the axis by a rotation
  double plane_rms = 0;   ///< of the rings' cameras off their planes, over the mean camera distance
  double circle_rms = 0;  ///< of the rings' cameras off circles about the common axis, over the
                          ///< mean camera distance
  std::vector<int> ring_of_view;  ///< -1 for views of no ring
  bool centered_on_axis = false;  ///< else on the middle of the object's points
};

/// The frame: z along the turntable's axis, up as the cameras see it; lowest object point (1 %
/// quantile) at z = 0; the axis (or, where the cameras form no rings about one, the object's
/// middle) at x = y = 0; the first camera in direction -y; mean camera distance to the object's
/// middle 1.
///
/// Cameras that a turntable (or a walk around the object) leaves in one ring differ by rotations
/// about its axis, whatever their roll and elevation and however many are missing. The axis is
/// where the axes of all pairs' relative rotations crowd; the rings' planes then refine it.
/// @throws InputError  fewer than 3 views or fewer than 10 points, or all cameras in one place
Leveling LevelScene(const Scene& scene);

}  // namespace keypose::reconstruct
