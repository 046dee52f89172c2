// A picture of the correspondence: a pattern on the source, transferred to the target.
#pragma once

#include <vector>

#include "core/values/image.h"
#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"

namespace keypose::registration {

struct PictureOptions {
  int panel = 280;  ///< width and height of one panel [px]
  int cells = 16;   ///< checker cells along the source's diagonal
  /// distance that the error panel shows in full red, over the target's diagonal
  double error_at_red = 0.02;
  std::vector<double> turns_deg = {
      -35, 145};  ///< one row of panels each: the camera's turn about the picture's vertical
};

/// Draws rows of four panels: the source, the registered mesh and the target with the same pattern,
/// and the registered mesh coloured by its distance to the target. The pattern is a checker times
/// smooth colours of the source's position.
///
/// A point of the target takes the pattern of the nearest registered point. So a tear, a fold or a
/// shift of the correspondence shows in the checker. The target is grey where the nearest point
/// faces the other way or is more than 5 % of the diagonal away. Landmarks are white dots. The
/// camera looks along the target's shortest axis, turned by `turns_deg`.
/// @throws InputError  unusable mesh, sizes that do not fit, panel < 16
/// Same bits for any thread count.
Image8 DrawCorrespondence(const Mesh& source, const PointsX3& registered, const Mesh& target,
                          const std::vector<LandmarkGoal>& landmarks = {},
                          const PictureOptions& options = {});

}  // namespace keypose::registration
