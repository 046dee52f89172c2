// Masks that agree with each other in space, once the cameras are known.
#pragma once

#include <vector>

#include "capture/agreement/space_options.h"
#include "capture/board/board_detection.h"
#include "capture/segmentation/mask_holes.h"
#include "capture/segmentation/mask_options.h"
#include "core/camera.h"
#include "core/image.h"
#include "core/progress.h"

namespace keypose::capture {

struct RefinedMasks {
  std::vector<Image8> masks;
  std::vector<Backdrop> backdrops;  ///< to open narrow holes by at full size
  /// of each, see AgreementInSpace; at half the size
  std::vector<double> agreement_before, agreement;
  ViewConsensus consensus_before,
      consensus;  ///< of the views: which contradict the others, by the first masks and by the last
};

/// Segments the set again; the denials of the other views along each pixel's ray add to its odds,
/// weighed by how well denials tell inside from outside of the masks. A part of the set that only
/// some views took for the figure is denied by those that see past it; a part of the figure that
/// one view missed is upheld by all others.
///
/// A view whose first mask, or whose colours, contradict the others is an outlier: its denials do
/// not count, and those of the others do not guide it. Its next masks are what its photograph shows
/// by itself, with what the others taught of colours. If these contradict too, and still do when
/// the others guide them (a dark side before a dark set gives way, a place where the photograph
/// clearly shows the set does not), it stays an outlier; else it is an inlier again.
/// @param images  RGB at working size
/// @param masks   of the same size
/// @param views   with cameras of that size
/// @param boards  what the calibration board tells of each image; empty, or one for each, empty
/// where there
///                is none
/// Source: Campbell, Vogiatzis, Hernandez & Cipolla, "Automatic 3D object segmentation in multiple
/// views using volumetric graph-cuts", IVC 2010, which cuts the voxels; here the images are cut,
/// which keeps the outline as fine as they are.
RefinedMasks RefineInSpace(const std::vector<Image8>& images, const std::vector<Image8>& masks,
                           const std::vector<View>& views, const std::vector<BoardOdds>& boards,
                           const MaskOptions& masking, const SpaceOptions& options,
                           Progress* progress = nullptr);

}  // namespace keypose::capture
