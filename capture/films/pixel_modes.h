// The few colours that each pixel of a fixed camera shows in the course of a film.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/values/image.h"

namespace keypose::capture {

inline constexpr int kMostModes = 4;  ///< of a pixel
inline constexpr std::uint8_t kNoMode = 255;

/// One colour of a pixel, and how often it shows it.
struct PixelMode {
  std::array<std::uint8_t, 3> lab{};  ///< mean, 8 bit CIE Lab
  std::uint8_t share = 0;             ///< of the frames, out of 255
};

struct PixelModes {
  int width = 0, height = 0;
  /// kMostModes for each pixel, most frequent first; share 0: there is none
  std::vector<PixelMode> modes;
  /// for each frame the number of each pixel's mode, kNoMode: of none
  std::vector<Image8> labels;

  const PixelMode* of(std::size_t pixel) const { return &modes[pixel * kMostModes]; }
};

/// The distance of two colours of a pixel, as modes are told apart: lightness, which shadows and
/// noise change most, has half its weight.
double ModeDistance(const std::uint8_t* a, const std::uint8_t* b);

/// The distance up to which two values are of one mode: a few times what most pixels change from
/// one frame to the next, at least 6.
double ModeRadius(const std::vector<Image8>& lab);

/// @param lab     frames in CIE Lab, 8 bits per channel, of one size
/// @param radius  see ModeRadius
/// Same bits for any thread count.
PixelModes FindPixelModes(const std::vector<Image8>& lab, double radius);

}  // namespace keypose::capture
