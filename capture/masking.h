// Masks of an object photographed from all round before a background that differs from it in colour or in texture.
//
// What lies along the borders of all photographs is background, what lies in their middles is mostly object. Histograms of these two
// zones give each pixel odds; a photograph of the empty set, where there is one, gives better ones. A graph cut turns odds into one region
// with a smooth border; the regions of all photographs then take the place of the zones, twice, as in GrabCut but over the whole set. A
// guided filter carries the borders from the working size to full resolution.
// Source: Boykov & Jolly, ICCV 2001; Rother, Kolmogorov & Blake, "GrabCut", SIGGRAPH 2004; He, Sun & Tang, "Guided Image Filtering", ECCV
// 2010.
#pragma once

#include <vector>

#include "capture/board_detection.h"
#include "capture/gaps.h"
#include "core/image.h"
#include "core/progress.h"

namespace keypose::capture {

struct MaskOptions {
  int working_px = 512;        ///< longer side of the images that are segmented
  int rounds = 4;              ///< segmentations; each but the first learns from the one before
  double border_share = 0.06;  ///< width of the border zone over the image's longer side
  double smoothness = 12;      ///< cost of a border between two pixels of one colour, in log odds
  double odds_limit = 6;       ///< what one pixel can weigh at most, in log odds
  double largest_misfit = 6;  ///< of the empty set, as far as it is known, to what is seen of it (8 bit Lab), up to which it is made use of
  double plate_difference = 6;  ///< CIE Lab distance to the background plate at which a pixel is as likely object as not
};

/// Segments a whole set.
///
/// @param images  RGB at working size, at least one
/// @param plate   RGB photograph of the empty set at the same size, or empty
/// @param boards  what the printed plate tells of each image; empty, or one for each, empty where there is none
/// @return one mask for each image: 255 in the object, which is one region; all zero where nothing looks like an object
/// @throws InputError  no images, or a plate of another size
/// Same bits for any thread count.
std::vector<Image8> SegmentSet(const std::vector<Image8>& images, const Image8& plate, const std::vector<BoardOdds>& boards,
                               const MaskOptions& options, Progress* progress = nullptr);

/// A small mask carried to the size of `image`, its border moved to the image's edges; with a backdrop, its narrow gaps open.
Image8 RefinedMask(const Image8& image, const Image8& small_mask, const Backdrop* backdrop = nullptr);

/// The image shrunk so that its longer side is `working_px` (never enlarged).
Image8 WorkingImage(const Image8& image, int working_px);

/// BT.601 luma of an RGB image.
Image8 Grey(const Image8& image);

/// Share of pixels above 127.
double MaskFraction(const Image8& mask);

}  // namespace keypose::capture
