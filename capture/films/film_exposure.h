// The frames of a fixed camera brought to one exposure.
#pragma once

#include <array>
#include <vector>

#include "core/values/image.h"

namespace keypose::capture {

/// Factors of red, green and blue by which a frame's values become those of the film's usual
/// exposure.
using ExposureGain = std::array<double, 3>;

/// A camera's automatic exposure and white balance change the whole picture at once. Each frame's
/// gain is the median, over pixels that are neither dark nor burnt out, of the film's usual value
/// over the frame's: what moves covers less than half of the picture.
/// @param frames  RGB, all of one size, of a camera that stands still
/// @return one for each frame; 1 where the picture has nothing to compare
std::vector<ExposureGain> ExposureGains(const std::vector<Image8>& frames);

/// The gain of one more frame.
/// @param usual  the film's usual picture, e.g. the median of its frames
ExposureGain ExposureGainOf(const Image8& frame, const Image8& usual);

/// The picture with its values times the gain.
Image8 WithGain(const Image8& frame, const ExposureGain& gain);

/// The median of frames, channel by channel.
Image8 MedianOf(const std::vector<Image8>& frames);

}  // namespace keypose::capture
