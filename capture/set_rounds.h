// One round of segmentation over a whole set: learn from zones, cut every image.
#pragma once

#include <vector>

#include "capture/board_detection.h"
#include "capture/empty_set.h"
#include "capture/masking.h"

namespace keypose::capture {

/// Everything one round knows of the set.
struct Round {
  const std::vector<Image8>& images;  ///< RGB
  std::vector<Image8> lab;            ///< of the same
  std::vector<Image8> zones;          ///< what is believed of their pixels
  std::vector<Take> takes;
  const std::vector<Image8>* told = nullptr;  ///< what is known of each image's pixels from elsewhere, as kinds
  std::vector<float> odds_told;               ///< log odds of each of these kinds, added to what is learned
};

/// The last round's mask as zones; the pixels at its border, which mix both, belong to neither.
Image8 ZonesOf(const Image8& mask);

/// Zones or a mask at another size, values kept.
Image8 Enlarged(const Image8& zones, int width, int height);

/// What the printed plate tells, for images of half the size.
std::vector<BoardOdds> Halved(const std::vector<BoardOdds>& boards, const std::vector<Image8>& small);

/// Learns the zones' colours, then segments each image by the set's odds and its own together.
std::vector<Image8> SegmentByColor(const std::vector<Image8>& images, const std::vector<Image8>& zones,
                                   const std::vector<BoardOdds>& boards, const MaskOptions& options);

/// Learns from the zones, then segments each image by what the others taught. Zones must be nearly right.
///
/// A forest of trees tells object from background by colour, by the difference to the empty set as far as that is known, and by contrast.
/// Each quarter of the set is judged by a forest that learned from the other three, so that an error that neighbours share does not confirm
/// itself. What looks like the empty set in shadow, and is seen at the masks' rims far oftener than well inside, is shadow.
std::vector<Image8> SegmentByForest(const Round& round, const std::vector<BoardOdds>& boards, const MaskOptions& options);

}  // namespace keypose::capture
