// A picture of two poses with numbered landmarks, for a person to check.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::registration {

/// A landmark to draw. Its number is its position in the list, from 1.
struct DrawnPair {
  Eigen::Vector3d source, target;  ///< on the meshes
  bool confirmed = false;          ///< drawn as a square if true, else as a disc
};

struct LandmarkPictureOptions {
  int panel = 360;                                       ///< width and height of one view [px]
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();         ///< upwards in the picture
  std::vector<double> azimuths_deg = {0, 90, 180, 270};  ///< one column each
  std::string source_name = "source", target_name = "target";  ///< written beside the rows
};

/// Draws the source in the first row and the target in the second, from the same sides. A landmark
/// is drawn where it is visible. A pair that these views do not show on both meshes gets its own
/// column, with a view that faces its landmark on each mesh. These columns follow in further pairs
/// of rows. There, a landmark that no view can see is drawn as a ring.
///
/// Meshes have their own colours. If neither has colours, `dense` gives tints.
/// @param dense  for each source vertex a target vertex or -1. The source is tinted by position; a
///               target vertex takes the tint of the source vertex that is mapped nearest to it.
///               Empty: both are grey.
/// @throws InputError  unusable mesh, panel < 64, no views, `dense` of wrong length
/// Same bits for any thread count.
Image8 DrawLandmarks(const Mesh& source, const Mesh& target, const std::vector<DrawnPair>& pairs,
                     const std::vector<int>& dense, const LandmarkPictureOptions& options = {});

}  // namespace keypose::registration
