// Refines a placement by outlines, inner edges, features and grey values, coarse to fine.
#pragma once

#include <vector>

#include "composite/locating/refinement/picture_evidence.h"

namespace keypose::composite {

/// One size of the picture.
struct RefineStep {
  double reach_px = 10, last_reach_px = 3;  ///< of outlines: falls from the first to the last round
  int rounds = 6;
  const GreyTexture* texture = nullptr;
  bool edges = false;
  double matte_offset_px = 0;  ///< of the whole picture, as in Terms
};

/// @param at  with the whole picture's camera, as the result
Placement Refined(const Figure& figure, const PictureEvidence& evidence, const Placement& at,
                  const RefineStep& step, const LensPrior& lens);

/// Several frames with one lens. Each has its own place.
struct SharedFrame {
  const Figure* figure;
  const PictureEvidence* evidence;
  Placement at;
};
/// @param frames  their placements are refined; all end with one lens
/// @return by how much mattes lie outside of the figure all round [px of the whole picture]: the
/// step's, unless the lens's prior leaves it free. Mattes and scans err alike in all frames; taken
/// for the figure's size, that would be a wrong focal length and distance.
double RefineShared(std::vector<SharedFrame>& frames, const RefineStep& step,
                    const LensPrior& lens);
/// Several frames with one lens and one place: the meshes are in one frame of coordinates, and the
/// camera stands still.
Placement RefinedStill(const std::vector<SharedFrame>& frames, const Placement& at,
                       const RefineStep& step, const LensPrior& lens);

/// The lens's part of one frame's equations when its place is solved for each lens, and back.
struct LensPart {
  Eigen::Matrix3d h;  ///< of the focal length's logarithm, k1 and the matte's offset
  Eigen::Vector3d g;
  Eigen::Matrix<double, 6, 3> place_by_lens;
  Eigen::Matrix<double, 6, 1> place;
};
LensPart Eliminated(const NormalEquations& equations);

/// How well the pictures would show the lens's centre if it were solved: its standard deviation [px
/// of the whole picture] in the worse direction, by the equations' weights (the bound of Cramer and
/// Rao for the noise that they stand for). Infinite when they do not show it at all.
double CenterDeviation(const std::vector<SharedFrame>& frames, const RefineStep& step,
                       const LensPrior& lens);

/// How well the focal length is known from the pictures alone.
struct FocalProfile {
  double best_px = 0;
  double deviation =
      0;  ///< of its logarithm: where twice the log likelihood falls by one; at most 1
};
/// Profile likelihood: the place is solved anew for each of several focal lengths.
FocalProfile ProfileFocal(std::vector<SharedFrame> frames, double reach_px,
                          double matte_offset_px = 0);

/// What is left of the focal length's deviation (of its logarithm) since the matte's offset is not
/// known better than its prior and the pictures say. No number of outlines makes that less.
double FocalDeviationByOffset(const std::vector<SharedFrame>& frames, const RefineStep& step,
                              const LensPrior& lens);

/// The placement with another focal length, moved in depth so that its size stays.
Placement WithFocal(const Placement& at, double focal_px, const Eigen::Vector3d& center);

}  // namespace keypose::composite
