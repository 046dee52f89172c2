#include "core/io/pictures/drawn_matte.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "core/io/pictures/drawn_mask.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/pictures/given_matte.h"
#include "core/pictures/image_turns.h"
#include "core/pictures/mask_channels.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

constexpr float kDark = 32;            // of 255: no matte of many levels is as dark all over
constexpr double kLeastSide = 0.0005;  // a level of fewer pixels is noise

/// Pixels of up to three of its levels.
std::map<float, std::size_t> SomeLevels(const ImageF& levels) {
  std::map<float, std::size_t> some;
  for (const float level : levels.data)
    if (++some[level]; some.size() > 2) break;
  return some;
}

/// Whether there are two levels, and neither is noise on the other.
bool AreTwoSides(const std::map<float, std::size_t>& some, std::size_t pixels) {
  if (some.size() != 2) return false;
  const auto fewer = std::min(some.begin()->second, some.rbegin()->second);
  return static_cast<double>(fewer) >= kLeastSide * static_cast<double>(pixels);
}

DrawnMatte MatteOfLevels(const ImageF& levels, bool lossless, const std::string& name) {
  DrawnMatte drawn;
  drawn.matte = Image8(levels.width, levels.height, 1);
  const std::map<float, std::size_t> some = SomeLevels(levels);
  const auto fill = [&](auto value) {
    std::transform(levels.data.begin(), levels.data.end(), drawn.matte.data.begin(), value);
  };
  const bool black = !lossless && IsEmptyMatte(levels);
  if (!black && AreTwoSides(some, levels.data.size())) {
    const float low = some.begin()->first, high = some.rbegin()->first;
    drawn.stretched = low > 0 || high < 255;
    fill([&](float level) { return static_cast<std::uint8_t>(level > low ? 255 : 0); });
    return drawn;
  }
  const float highest = *std::max_element(levels.data.begin(), levels.data.end());
  if (!black && highest < kDark && some.size() > 2)
    throw InputError(fmt::format(
        "matte {} is dark all over, its brightest level is {:g} of 255; what is covered must be "
        "white, all else black",
        name, highest));
  fill([](float level) { return static_cast<std::uint8_t>(std::lround(level)); });
  return drawn;
}

/// The brightest of three channels. Colours are none of a matte.
ImageF GreyOfMatte(const ImageF& rgb, const std::string& name) {
  ImageF grey = BrightestChannel(rgb);
  if (IsColoured(rgb) && SomeLevels(grey).size() > 2)
    throw InputError(
        fmt::format("matte {} is a picture in colours; a matte is white where something covers the "
                    "picture and black elsewhere, or has it in its alpha",
                    name));
  return grey;
}

}  // namespace

DrawnMatte ReadDrawnMatte(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  if (const Image8 alpha = ReadAlpha(path); AlphaIsMask(alpha))
    return MatteOfLevels(AsLevels(alpha), true, name);
  return MatteOfLevels(GreyOfMatte(ReadLevels(path, 3), name), KeepsLevels(path), name);
}

Image8 PlacedMatte(Image8 matte, int width, int height, int orientation, const std::string& what,
                   MatteChange* change) {
  MatteChange done;
  if (LiesAsStored(matte, width, height, orientation)) {
    matte = Oriented(std::move(matte), orientation);
    done.turned = true;
  }
  if (!CanLieOn(matte, width, height))
    throw InputError(fmt::format(
        "{} has {} x {} pixels, but the picture {} x {}; make it at the picture's size, or smaller "
        "in its shape",
        what, matte.width, matte.height, width, height));
  if (matte.width != width || matte.height != height) {
    matte = Resized(matte, width, height);
    done.resized = true;
  }
  if (change) *change = done;
  return matte;
}

}  // namespace keypose
