// One round of segmentation over a whole set: learn from trimaps, cut every image.
#pragma once

#include <vector>

#include "capture/board/board_detection.h"
#include "capture/segmentation/empty_set.h"
#include "capture/segmentation/mask_options.h"
#include "capture/segmentation/trimap.h"

namespace keypose::capture {

/// Everything one round knows of the set.
struct Round {
  const std::vector<Image8>& images;  ///< RGB
  std::vector<Image8> lab;            ///< of the same
  std::vector<Image8> trimaps;        ///< what is believed of their pixels
  std::vector<Take> takes;
  /// what is known of each image's pixels from elsewhere, as kinds
  const std::vector<Image8>* told = nullptr;
  std::vector<float> odds_told;  ///< log odds of each of these kinds, added to what is learned
};

/// A trimap or a mask at another size, values kept.
Image8 Enlarged(const Image8& image, int width, int height);

/// What the calibration board tells, for images of half the size.
std::vector<BoardOdds> Halved(const std::vector<BoardOdds>& boards,
                              const std::vector<Image8>& small);

/// Learns the colours of object and background, then segments each image by the set's odds and its
/// own together.
std::vector<Image8> SegmentByColor(const std::vector<Image8>& images,
                                   const std::vector<Image8>& trimaps,
                                   const std::vector<BoardOdds>& boards,
                                   const MaskOptions& options);

/// Learns from the trimaps, then segments each image by what the others taught. Trimaps must be
/// nearly right.
///
/// A pixel classifier tells object from background by colour, by the difference to the empty set as
/// far as that is known, and by contrast. Each quarter of the set is judged by a classifier that
/// learned from the other three, so that an error that neighbours share does not confirm itself.
/// What looks like the empty set in shadow, and is seen at the masks' rims far oftener than well
/// inside, is shadow.
std::vector<Image8> SegmentByClassifier(const Round& round, const std::vector<BoardOdds>& boards,
                                        const MaskOptions& options);

}  // namespace keypose::capture
