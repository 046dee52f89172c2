// A picture of the correspondence: a pattern painted on the source and carried over.
#pragma once

#include <vector>

#include "core/image.h"
#include "core/landmark_goal.h"
#include "core/mesh.h"

namespace keypose::registration {

struct PictureOptions {
  int panel = 280;  ///< width and height of one panel [px]
  int cells = 16;   ///< checker cells along the source's diagonal
  /// distance over the target's diagonal that the error panel shows in full red
  double error_at_red = 0.02;
  std::vector<double> turns_deg = {
      -35, 145};  ///< one row of panels each: the camera's turn about the picture's vertical
};

/// Rows of four panels: the source, the registered mesh, the target, all with the same pattern
/// (smooth colours of the source's position times a checker), and the registered mesh coloured by
/// its distance to the target. The target's point takes the pattern of the nearest registered
/// point, so a tear, a fold or a slide shows as a torn, folded or slid checker; where the nearest
/// point faces the other way or is more than 5 % of the diagonal off, the target is grey. Landmarks
/// are white dots. The camera looks along the target's shortest axis.
/// @throws InputError  unusable mesh, sizes that do not fit, panel < 16
/// Same bits for any thread count.
Image8 DrawCorrespondence(const Mesh& source, const PointsX3& registered, const Mesh& target,
                          const std::vector<LandmarkGoal>& landmarks = {},
                          const PictureOptions& options = {});

}  // namespace keypose::registration
