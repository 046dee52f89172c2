#include "core/pictures/given_matte.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

namespace keypose {
namespace {

constexpr double kBorderCovered = 0.9, kAllCovered = 0.999;

bool IsOfSize(const Image8& image, int width, int height) {
  return image.width == width && image.height == height;
}

template <class T>
bool HoldsNoiseAlone(const ImageT<T>& image) {
  constexpr int kNoise = 8;
  return std::all_of(image.data.begin(), image.data.end(), [](T value) { return value <= kNoise; });
}

}  // namespace

bool HasShapeOf(const Image8& image, int width, int height) {
  const std::int64_t a = std::int64_t{image.width} * height, b = std::int64_t{image.height} * width;
  return std::abs(a - b) <= std::max({width, height, image.width, image.height});
}

bool CanLieOn(const Image8& matte, int width, int height) {
  constexpr int kMostEnlarged = 8;  // a smaller one has no outline that would be worth using
  return HasShapeOf(matte, width, height) && matte.width * kMostEnlarged >= width;
}

bool LiesAsStored(const Image8& matte, int width, int height, int orientation) {
  constexpr int kOnItsSide = 5;  // and above, as EXIF counts
  if (orientation < kOnItsSide || IsOfSize(matte, width, height)) return false;
  // Of pictures that are nearly square, both ways have the shape, but only one has the size.
  return IsOfSize(matte, height, width) ||
         (!HasShapeOf(matte, width, height) && HasShapeOf(matte, height, width));
}

bool IsEmptyMatte(const Image8& matte) { return HoldsNoiseAlone(matte); }

bool IsEmptyMatte(const ImageF& levels) { return HoldsNoiseAlone(levels); }

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
