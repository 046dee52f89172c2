// Masks of an object photographed from all round before a background that differs from it in colour
// or in texture.
//
// What lies along the borders of all photographs is background, what lies in their middles is
// mostly object: the first trimap. Histograms of these two kinds of pixels give each pixel odds; a
// clean plate (a photograph of the empty set), where there is one, gives better ones. A graph cut
// turns odds into one region with a smooth border; trimaps of these regions then take the place of
// the first one, twice, as in GrabCut but over the whole set. A guided filter carries the borders
// from the working size to full resolution. Source: Boykov & Jolly, ICCV 2001; Rother, Kolmogorov &
// Blake, "GrabCut", SIGGRAPH 2004; He, Sun & Tang, "Guided Image Filtering", ECCV 2010.
#pragma once

#include <vector>

#include "capture/board/board_detection.h"
#include "capture/segmentation/mask_holes.h"
#include "capture/segmentation/mask_options.h"
#include "core/image.h"
#include "core/progress.h"

namespace keypose::capture {

/// Segments a whole set.
///
/// @param images       RGB at working size, at least one
/// @param clean_plate  RGB photograph of the empty set at the same size, or empty
/// @param boards       what the calibration board tells of each image; empty, or one for each,
/// empty
///                     where there is none
/// @return one mask for each image: 255 in the object, which is one region; all zero where nothing
/// looks
///         like an object
/// @throws InputError  no images, or a clean plate of another size
/// Same bits for any thread count.
std::vector<Image8> SegmentSet(const std::vector<Image8>& images, const Image8& clean_plate,
                               const std::vector<BoardOdds>& boards, const MaskOptions& options,
                               Progress* progress = nullptr);

/// A small mask carried to the size of `image`, its border moved to the image's edges; with a
/// backdrop, narrow holes in it are opened.
Image8 RefinedMask(const Image8& image, const Image8& small_mask,
                   const Backdrop* backdrop = nullptr);

}  // namespace keypose::capture
