// Masks of an object photographed from all round in front of a background that differs from it in
// colour or in texture.
//
// Pixels along the borders of all photographs are background, pixels in their middles are mostly
// object: the first trimap. Histograms of these two kinds of pixels give each pixel odds; a clean
// plate (a photograph of the empty set), if there is one, gives better ones. A graph cut converts
// odds to one region with a smooth border. Trimaps of these regions then replace the first one,
// twice, as in GrabCut but over the whole set. A guided filter transfers the borders from the
// working size to full resolution.
// Source: Boykov & Jolly, ICCV 2001; Rother, Kolmogorov & Blake, "GrabCut", SIGGRAPH 2004; He, Sun
// & Tang, "Guided Image Filtering", ECCV 2010.
#pragma once

#include <vector>

#include "capture/board/board_detection.h"
#include "capture/segmentation/mask_holes.h"
#include "capture/segmentation/mask_options.h"
#include "core/values/image.h"
#include "core/values/progress.h"

namespace keypose::capture {

/// Segments a whole set.
///
/// @param images       RGB at working size, at least one
/// @param clean_plate  RGB photograph of the empty set at the same size, or empty
/// @param boards       odds from the calibration board for each image; empty, or one per image,
/// empty where there is none
/// @param all_regions  for each image whether all its regions are returned, not the best alone;
/// empty: of none
/// @return one mask per image: 255 in the object, which is one region unless all are asked for; all
/// zero if nothing looks like an object
/// @throws InputError  no images, or a clean plate of another size
/// Same bits for any thread count.
std::vector<Image8> SegmentSet(const std::vector<Image8>& images, const Image8& clean_plate,
                               const std::vector<BoardOdds>& boards, const MaskOptions& options,
                               Progress* progress = nullptr,
                               const std::vector<char>& all_regions = {});

/// A small mask at the size of `image`, with its border moved to the image's edges; with a
/// backdrop, narrow holes in it are opened.
Image8 RefinedMask(const Image8& image, const Image8& small_mask,
                   const Backdrop* backdrop = nullptr);

/// RefinedMask with all of the mask's regions, not the best alone.
Image8 RefinedRegions(const Image8& image, const Image8& small_mask,
                      const Backdrop* backdrop = nullptr);

}  // namespace keypose::capture
