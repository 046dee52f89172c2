// What a photograph would show without the figure, and how its pixels differ from that.
#pragma once

#include <array>
#include <vector>

#include "capture/segmentation/pixel_classifier.h"
#include "core/image.h"

namespace keypose::capture {

/// Photographs before one unmoved background, as a camera on a tripod and a turntable make them:
/// [begin, end) in the set's order.
struct Take {
  std::size_t begin = 0, end = 0;
};

/// The take of photograph i.
inline const Take& TakeOf(const std::vector<Take>& takes, std::size_t i) {
  for (const Take& take : takes)
    if (i < take.end) return take;
  return takes.back();
}

/// Splits the set, in its order, where what lies along the borders changes. A background without
/// any structure never tells.
std::vector<Take> FindTakes(const std::vector<Image8>& images, double border_share);

/// The empty set behind image `i`, in CIE Lab, 8 bits a channel as OpenCV has it: where the others
/// of its take show it (the median of those whose trimap has background there), these; elsewhere
/// its own background, smoothly carried in below the figure.
Image8 EmptySet(const std::vector<Image8>& lab, const std::vector<Image8>& trimaps,
                const Take& take, std::size_t i);

/// RGB to CIE Lab, 8 bits a channel.
Image8 LabOf(const Image8& rgb);

/// What describes the pixels of one image: Lab; the difference of Lab to the empty set, sharp and
/// smoothed; local contrast at two sizes.
std::vector<PixelFeatures> FeaturesOf(const Image8& lab, const Image8& empty_lab);

/// How far the background of an image is from its empty set: root mean square of lightness, 8 bit
/// Lab.
double Misfit(const Image8& lab, const Image8& empty_lab, const Image8& trimap);

/// How far, channel by channel, most of an image's background is from its empty set.
std::array<int, 3> UsualDifference(const Image8& lab, const Image8& empty_lab,
                                   const Image8& trimap);

/// Share of a figure that looks like the empty set, from which on the figure itself is taken to
/// have such colours.
inline constexpr double kManyAlike = 1.5e-3;

/// The same pixels without what refers to the empty set.
std::vector<PixelFeatures> WithoutEmptySet(std::vector<PixelFeatures> features);

inline constexpr int kShadowKinds = 8 * 2 * 3;

/// Pixels that may be the empty set in shadow: darker than it, of its hue, and smooth. These are 1
/// + a kind, of kShadowKinds, by how much darker, how near in hue and how smooth; others 0.
Image8 ShadowKinds(const Image8& lab, const Image8& empty_lab);

}  // namespace keypose::capture
