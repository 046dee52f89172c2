// Where a photograph shows patches of a render, over a wide range and turned in the picture.
#pragma once

#include <vector>

#include "fit/appearance/patch_shift.h"
#include "fit/appearance/textured_render.h"

namespace keypose::fit {

/// The pictures that are compared, of one resolution.
struct PatchPictures {
  const TexturedRender& render;
  const ImageF& photo;   ///< brightness
  const GreyMask& mask;  ///< of the photograph; the lowest bit is set inside
  double focal = 1;      ///< [px]
};

struct FoundPatch {
  bool found = false;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();  ///< from the render to the photograph [px]
  double turn = 0;                                  ///< in the picture, from x to y [rad]
  double correlation = 0;                           ///< of patch and photograph there
};

struct PatchSearch {
  int radius = 7;                  ///< half the patch's side [px]
  double reach_px = 15;            ///< largest shift
  double most_turn = 0.56;         ///< largest turn [rad]
  double least_correlation = 0.7;  ///< of the best place
  /// largest distance of the best place's correlation from 1, over that of the best at another
  /// place
  double best_ratio = 0.8;
};

/// The shift and turn of the patch around each seen vertex under which it correlates best with the
/// photograph, of all whole shifts within reach. Brightness may differ by a factor and an offset.
/// Pixels beside the vertex's own surface, and of the photograph outside of the mask, do not count.
/// A patch is not found if it looks nearly the same at two places.
/// Cost: as many comparisons of patches as there are shifts and turns.
/// Source: template matching by normalised cross-correlation (Lewis, Vision Interface 1995).
std::vector<FoundPatch> SearchPatches(const std::vector<SeenVertex>& seen,
                                      const PatchPictures& pictures, const PatchSearch& search);

/// The same at twice the resolution, from where the patches of half the resolution were found.
/// @param coarse  of the same vertices, at half the resolution
/// @return found only where `coarse` is
std::vector<FoundPatch> RefinePatches(const std::vector<SeenVertex>& seen,
                                      const std::vector<FoundPatch>& coarse,
                                      const PatchPictures& pictures, const PatchSearch& search);

}  // namespace keypose::fit
