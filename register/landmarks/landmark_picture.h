// Two poses beside each other with numbered landmarks, for a person to confirm by eye.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/mesh.h"

namespace keypose::registration {

/// A landmark to draw; its number is its place in the list, from 1.
struct DrawnPair {
  Eigen::Vector3d source, target;  ///< on the meshes
  bool confirmed = false;          ///< drawn as a square, else as a disc
};

struct LandmarkPictureOptions {
  int panel = 360;                                       ///< width and height of one view [px]
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();         ///< upwards in the picture
  std::vector<double> azimuths_deg = {0, 90, 180, 270};  ///< one column each
  std::string source_name = "source", target_name = "target";  ///< written beside the rows
};

/// The source in the first row, the target in the second, from the same sides; a landmark is drawn
/// where it can be seen. A pair that no side shows on both gets a column of its own, in which
/// either mesh is seen most squarely at its mark; these go into further pairs of rows. A mark that
/// can be seen from nowhere is a ring there.
///
/// Meshes are in their own colours. Where neither has any, `dense` tints them:
/// @param dense  for each source vertex a target vertex or -1: the source is tinted by position and
/// the target takes the tint of the
///               source vertex mapped nearest; empty leaves both grey
/// @throws InputError  unusable mesh, panel < 64, no views
/// Same bits for any thread count.
Image8 DrawLandmarks(const Mesh& source, const Mesh& target, const std::vector<DrawnPair>& pairs,
                     const std::vector<int>& dense, const LandmarkPictureOptions& options = {});

}  // namespace keypose::registration
