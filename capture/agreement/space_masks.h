// Masks that agree with each other in space, once the cameras are known.
#pragma once

#include <vector>

#include "capture/agreement/space_options.h"
#include "capture/board/board_detection.h"
#include "capture/segmentation/mask_holes.h"
#include "capture/segmentation/mask_options.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/progress.h"

namespace keypose::capture {

struct RefinedMasks {
  std::vector<Image8> masks;
  std::vector<Backdrop> backdrops;  ///< for opening narrow holes at full size
  /// for each mask, see AgreementInSpace; at half the size
  std::vector<double> agreement_before, agreement;
  ViewConsensus consensus_before,
      consensus;  ///< of the views, with the initial masks and with the final ones
};

/// Segments the set again. The number of contradictions by other views along each pixel's ray is
/// added to its odds; its weight depends on how well contradictions separate inside from outside of
/// the masks. A part of the set that only some masks include has contradictions by views that see
/// past it. A part of the figure that one mask lacks has none from the others.
///
/// A view whose initial mask or colours are inconsistent with the others is an outlier: its
/// contradictions do not count, and the others' contradictions are not used for it. Its next mask
/// then depends on its photograph alone, with the colours learned from the other photographs. If
/// that mask is still inconsistent, it is segmented once more with the others' contradictions. That
/// corrects a dark side in front of a dark set, but not a place where the photograph clearly shows
/// the set. If the result is consistent, the view becomes an inlier again; else it stays an
/// outlier.
/// @param images  RGB at working size
/// @param masks   of the same size
/// @param views   with cameras of that size
/// @param boards  odds from the calibration board for each image; empty, or one per image, empty
/// where there is none
/// Source: Campbell, Vogiatzis, Hernandez & Cipolla, "Automatic 3D object segmentation in multiple
/// views using volumetric graph-cuts", IVC 2010. That method cuts the voxels; here the images are
/// cut, so the outline has the images' resolution.
RefinedMasks RefineInSpace(const std::vector<Image8>& images, const std::vector<Image8>& masks,
                           const std::vector<View>& views, const std::vector<BoardOdds>& boards,
                           const MaskOptions& masking, const SpaceOptions& options,
                           Progress* progress = nullptr);

}  // namespace keypose::capture
