// Few colours for many: a palette for pictures, and pictures in the colours of a palette.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/values/image.h"

namespace keypose {

/// sRGB colours.
struct Palette {
  std::vector<std::array<std::uint8_t, 3>> colors;
  /// Index of the colour that looks closest; of several the first.
  int Nearest(const std::array<int, 3>& color) const;
};

/// Collects the colours of pictures and chooses a palette for all of them: the box of colours with
/// the largest squared error is split at its mean until there are enough, then each colour moves to
/// the mean of those that are nearest to it (k-means). The most frequent colour of the first
/// picture, which is the background, is kept exactly.
/// Source: Heckbert, Color image quantization for frame buffer display, 1982, with the split of Wu,
/// Graphics Gems II, 1991, along one axis at the mean.
class ColorCounts {
 public:
  ColorCounts();
  /// @param picture  RGB
  void Add(const Image8& picture);
  /// @param count  at least 2
  /// @return at most `count` colours, different ones, the background first
  Palette Choose(int count) const;

 private:
  struct Bin {
    std::int64_t count = 0, sum[3] = {0, 0, 0};
  };
  std::vector<Bin> bins_;  ///< 6 bits a channel
  std::array<std::uint8_t, 3> background_{};
  bool empty_ = true;
};

/// Turns the pictures of a film into indices of a palette by diffusion of the error (Floyd and
/// Steinberg, 1976, in alternating directions). A pixel whose colour stays within kSameColor levels
/// of what it was keeps its index, so that the grain of what stands still does not crawl.
class Ditherer {
 public:
  static constexpr int kSameColor = 1;
  explicit Ditherer(Palette palette) : palette_(std::move(palette)) {}
  /// @param picture  RGB, all of one size
  /// @return 1 channel: indices into the palette
  Image8 Indices(const Image8& picture);

 private:
  bool Keeps(const std::uint8_t* color, std::size_t pixel) const;

  Palette palette_;
  Image8 shown_;     ///< colours that the indices were chosen for
  Image8 previous_;  ///< indices
};

}  // namespace keypose
