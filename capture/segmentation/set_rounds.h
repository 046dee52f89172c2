// One round of segmentation over a whole set: learning from trimaps, then cutting every image.
#pragma once

#include <vector>

#include "capture/board/board_detection.h"
#include "capture/segmentation/empty_set.h"
#include "capture/segmentation/mask_options.h"
#include "capture/segmentation/trimap.h"

namespace keypose::capture {

/// The data of one round.
struct Round {
  const std::vector<Image8>& images;  ///< RGB
  std::vector<Image8> lab;            ///< of the same
  std::vector<Image8> trimaps;        ///< assumed labels of the pixels
  std::vector<Take> takes;
  /// additional information for each image's pixels, as kinds
  const std::vector<Image8>* told = nullptr;
  std::vector<float> odds_told;  ///< log odds of each of these kinds, added to the learned ones
  /// for each image whether all its regions are kept, not the best alone; empty: of none
  std::vector<char> all_regions = {};
};

/// A trimap or a mask at another size, values kept.
Image8 Enlarged(const Image8& image, int width, int height);

/// The calibration board's odds for images of half the size.
std::vector<BoardOdds> Halved(const std::vector<BoardOdds>& boards,
                              const std::vector<Image8>& small);

/// Learns the colours of object and background, then segments each image by the combined odds of
/// the set and of the image itself.
std::vector<Image8> SegmentByColor(const std::vector<Image8>& images,
                                   const std::vector<Image8>& trimaps,
                                   const std::vector<BoardOdds>& boards,
                                   const MaskOptions& options);

/// Learns from the trimaps, then segments each image with classifiers learned from other images.
/// Trimaps must be nearly right.
///
/// A pixel classifier separates object from background by colour, by the difference from the empty
/// set if that is known, and by contrast. Each quarter of the set is classified by a classifier
/// learned from the other three, so that a common error of neighbouring images does not confirm
/// itself. Pixels are shadow if they look like the empty set in shadow and are far more frequent at
/// the masks' borders than well inside.
std::vector<Image8> SegmentByClassifier(const Round& round, const std::vector<BoardOdds>& boards,
                                        const MaskOptions& options);

}  // namespace keypose::capture
