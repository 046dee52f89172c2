// White from a grey card or the grey patches of a colour chart.
#pragma once

#include <array>
#include <optional>

#include "core/values/image.h"
#include "core/values/image16.h"

namespace keypose::capture::shoot {

/// A rectangle of pixels.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Factors on linear red, green and blue; green's is 1.
using WhiteGains = std::array<double, 3>;

/// The gains that make the mean of the box grey.
/// @param image  sRGB
/// @throws InputError  the box leaves the picture, is too small, too dark, burnt out, or so
/// coloured that it is no grey card
WhiteGains GainsFromCard(const Image8& image, const PixelBox& box);

/// The largest even, rectangular, nearly grey patch inside of the picture: a grey card, or a grey
/// patch of a chart. Its middle, without its borders; nothing if there is none.
std::optional<PixelBox> FindCard(const Image8& image);

/// The image with the gains applied in linear light.
Image8 WithGains(const Image8& image, const WhiteGains& gains);
Image16 WithGains(const Image16& image, const WhiteGains& gains);

}  // namespace keypose::capture::shoot
