// The grain of filmed frames, measured between frames and made anew.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/values/image.h"

namespace keypose::composite {

/// Standard deviation of the noise by stored level, for each channel, and how alike neighbours are.
struct Grain {
  static constexpr int kBins = 8;                    ///< of 32 levels each
  std::array<std::array<double, kBins>, 3> sigma{};  ///< [levels of 255]
  double neighbours = 0;  ///< correlation of pixels side by side, 0 to 0.6
  double SigmaAt(int channel, double level) const;
  double MeanSigma() const;
};

/// From two pictures of the same set. Differences along rows of their difference leave out what
/// changes slowly, such as shadows and exposure.
///
/// @param a, b  RGB, stored levels, the same size
/// @param away  1 channel: > 127 where pixels do not count; empty: all count
/// @param share_b  of the grain that b has: 1 a frame, 0 a picture without grain
/// @return none when fewer than 2000 pixels count
/// Robust: by the median of absolute differences, so that what moved does not count.
std::optional<Grain> MeasureGrain(const Image8& a, const Image8& b, const Image8& away,
                                  double share_b = 1);

/// Adds grain to stored levels.
///
/// @param levels  RGB, 0 to 255
/// @param share   1 channel, 0 to 1: how much of the grain's variance a pixel lacks; empty: all of
/// it
/// @param seed    the same gives the same grain
/// @return levels, 0 to 255, not rounded: they may be stored with more than 8 bits
/// Same bits for any thread count.
ImageF WithGrain(const ImageF& levels, const Grain& grain, const ImageF& share, std::uint64_t seed);

/// Adds grain to linear light of any range, of such a size as it has at the light's stored level;
/// above white as at white. Pixels without a share stay as they are, to the bit.
/// @param light  RGB
/// For the rest as WithGrain.
ImageF LightWithGrain(const ImageF& light, const Grain& grain, const ImageF& share,
                      std::uint64_t seed);

}  // namespace keypose::composite
