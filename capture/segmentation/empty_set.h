// The empty set behind each photograph, and the differences of its pixels from it.
#pragma once

#include <array>
#include <vector>

#include "capture/segmentation/pixel_classifier.h"
#include "core/values/image.h"
#include "core/values/tuned.h"

namespace keypose::capture {

/// Photographs with the same fixed background, from a camera on a tripod and a turntable: indices
/// into the set, ascending. All have one size.
struct Take {
  std::vector<std::size_t> images;
};

/// The take of photograph i.
/// @pre it has one
const Take& TakeOf(const std::vector<Take>& takes, std::size_t i);

/// Splits the photographs of each size, in the set's order, where the image borders change. A
/// background without structure never gives a split.
std::vector<Take> FindTakes(const std::vector<Image8>& images, double border_share);

/// The empty set behind image `i`, in CIE Lab, 8 bits per channel as in OpenCV. Where other images
/// of its take show it, it is the median of those whose trimap has background there; elsewhere the
/// image's own background, interpolated smoothly below the figure.
Image8 EmptySet(const std::vector<Image8>& lab, const std::vector<Image8>& trimaps,
                const Take& take, std::size_t i);

/// RGB to CIE Lab, 8 bits per channel.
Image8 LabOf(const Image8& rgb);

/// Features of the pixels of one image: Lab; the difference of Lab from the empty set, sharp and
/// smoothed; local contrast at two sizes.
std::vector<PixelFeatures> FeaturesOf(const Image8& lab, const Image8& empty_lab);

/// Difference of an image's background from its empty set: root mean square of lightness, 8 bit
/// Lab.
double Misfit(const Image8& lab, const Image8& empty_lab, const Image8& trimap);

/// Difference of most of an image's background from its empty set, channel by channel.
std::array<int, 3> UsualDifference(const Image8& lab, const Image8& empty_lab,
                                   const Image8& trimap);

/// Tuned on the skull and the plush dog, of which 0.7 and 1.4 % look like the empty set, and the
/// synthetic weak ring (docs/algorithms/masks.md). Sensitivity:
/// docs/results/sensitivity.md.
struct EmptySetTuning {
  /// share of a figure; if at least so much looks like the empty set, the figure has such colours
  KEYPOSE_TUNED(double, kManyAlike, 1.5e-3);
};

/// The same pixels without the features that depend on the empty set.
std::vector<PixelFeatures> WithoutEmptySet(std::vector<PixelFeatures> features);

inline constexpr int kShadowKinds = 8 * 2 * 3;

/// Pixels that may be the empty set in shadow: darker than it, with its hue, and smooth. They have
/// the value 1 + kind, with kShadowKinds kinds by how much darker, how close in hue and how smooth
/// they are; other pixels 0.
Image8 ShadowKinds(const Image8& lab, const Image8& empty_lab);

}  // namespace keypose::capture
