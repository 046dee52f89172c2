#include "core/io/pictures/drawn_matte.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <set>
#include <utility>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/pictures/image_turns.h"
#include "core/pictures/mask_channels.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

constexpr float kDark = 32;           // of 255: no matte of many levels is as dark all over
constexpr float kColourOfMatte = 24;  // channels of a grey picture differ by no more than this
constexpr double kColouredPart = 0.01;
constexpr int kMostResized = 8;
constexpr double kLeastSide = 0.0005;  // a level of fewer pixels is noise
constexpr double kBorderCovered = 0.9, kAllCovered = 0.999;

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

DrawnMatte MatteOfLevels(const ImageF& levels, const std::string& name) {
  DrawnMatte drawn;
  drawn.matte = Image8(levels.width, levels.height, 1);
  const std::map<float, std::size_t> some = SomeLevels(levels);
  const auto fill = [&](auto value) {
    std::transform(levels.data.begin(), levels.data.end(), drawn.matte.data.begin(), value);
  };
  if (AreTwoSides(some, levels.data.size())) {
    const float low = some.begin()->first, high = some.rbegin()->first;
    drawn.stretched = low > 0 || high < 255;
    fill([&](float level) { return static_cast<std::uint8_t>(level > low ? 255 : 0); });
    return drawn;
  }
  const float highest = *std::max_element(levels.data.begin(), levels.data.end());
  if (highest < kDark && some.size() > 2)
    throw InputError(fmt::format(
        "matte {} is dark all over, its brightest level is {:g} of 255; what is covered must be "
        "white, all else black",
        name, highest));
  fill([](float level) { return static_cast<std::uint8_t>(std::lround(level)); });
  return drawn;
}

/// The brightest of three channels. Colours are none of a matte.
ImageF GreyOfMatte(const ImageF& rgb, const std::string& name) {
  ImageF grey(rgb.width, rgb.height, 1);
  std::size_t coloured = 0;
  std::set<float> few;
  for (std::size_t p = 0; p < grey.data.size(); ++p) {
    const auto [low, high] =
        std::minmax({rgb.data[3 * p], rgb.data[3 * p + 1], rgb.data[3 * p + 2]});
    coloured += high - low > kColourOfMatte;
    grey.data[p] = high;
    if (few.size() <= 2) few.insert(high);
  }
  const bool is_coloured =
      static_cast<double>(coloured) >= kColouredPart * static_cast<double>(grey.data.size());
  if (is_coloured && few.size() > 2)
    throw InputError(
        fmt::format("matte {} is a picture in colours; a matte is white where something covers the "
                    "picture and black elsewhere, or has it in its alpha",
                    name));
  return grey;
}

bool HasShape(const Image8& image, int width, int height) {
  const std::int64_t a = std::int64_t{image.width} * height, b = std::int64_t{image.height} * width;
  return std::abs(a - b) <= std::max({width, height, image.width, image.height});
}

}  // namespace

DrawnMatte ReadDrawnMatte(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  if (const Image8 alpha = ReadAlpha(path); AlphaIsMask(alpha))
    return MatteOfLevels(AsLevels(alpha), name);
  return MatteOfLevels(GreyOfMatte(ReadLevels(path, 3), name), name);
}

Image8 PlacedMatte(Image8 matte, int width, int height, int orientation, const std::string& what,
                   MatteChange* change) {
  MatteChange done;
  if (orientation >= 5 && !HasShape(matte, width, height) && HasShape(matte, height, width)) {
    matte = Oriented(std::move(matte), orientation);
    done.turned = true;
  }
  if (!HasShape(matte, width, height) || matte.width * kMostResized < width)
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

bool IsEmptyMatte(const Image8& matte) {
  constexpr int kNoise = 8;
  return std::all_of(matte.data.begin(), matte.data.end(),
                     [](std::uint8_t value) { return value <= kNoise; });
}

bool IsFullMatte(const Image8& matte) {
  const auto covered = std::count_if(matte.data.begin(), matte.data.end(),
                                     [](std::uint8_t value) { return value > 127; });
  return static_cast<double>(covered) > kAllCovered * static_cast<double>(matte.data.size());
}

bool CoversBorder(const Image8& matte) {
  if (IsFullMatte(matte)) return false;
  std::int64_t white = 0, all = 0;
  for (int y = 0; y < matte.height; ++y) {
    const bool edge = y == 0 || y == matte.height - 1;
    for (int x = 0; x < matte.width; x += edge ? 1 : std::max(1, matte.width - 1)) {
      white += *matte.at(x, y) > 127;
      ++all;
    }
  }
  return static_cast<double>(white) > kBorderCovered * static_cast<double>(all);
}

Image8 InvertedMatte(Image8 matte) {
  for (std::uint8_t& value : matte.data) value = static_cast<std::uint8_t>(255 - value);
  return matte;
}

}  // namespace keypose
