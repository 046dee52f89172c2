#include "core/pictures/image_turns.h"

#include <algorithm>
#include <cstddef>

#include "core/values/image16.h"

namespace keypose {
namespace {

/// Where the picture's first pixel goes, and how far apart its neighbours along x and y come to
/// lie, in pixels of the turned picture.
struct Way {
  std::ptrdiff_t first, along_x, along_y;
};

Way WayOf(int orientation, std::ptrdiff_t width, std::ptrdiff_t height) {
  const std::ptrdiff_t last_x = width - 1, last_y = height - 1;
  switch (orientation) {
    case 2:
      return {last_x, -1, width};
    case 3:
      return {last_y * width + last_x, -1, -width};
    case 4:
      return {last_y * width, 1, -width};
    case 5:
      return {0, height, 1};
    case 6:
      return {last_y, height, -1};
    case 7:
      return {last_x * height + last_y, -height, -1};
    case 8:
      return {last_x * height, -height, 1};
    default:
      return {0, 1, width};
  }
}

template <class T>
ImageT<T> Turned(const ImageT<T>& image, int orientation) {
  const bool swap = orientation >= 5;
  const Way way = WayOf(orientation, image.width, image.height);
  ImageT<T> out(swap ? image.height : image.width, swap ? image.width : image.height,
                image.channels);
  // In squares: pixels of a column are far apart, and each brings its neighbours along.
  constexpr int kSide = 32;
  for (int y0 = 0; y0 < image.height; y0 += kSide)
    for (int x0 = 0; x0 < image.width; x0 += kSide)
      for (int y = y0; y < std::min(image.height, y0 + kSide); ++y) {
        const T* from = image.at(x0, y);
        T* to = out.data.data() + (way.first + x0 * way.along_x + y * way.along_y) * image.channels;
        for (int x = x0; x < std::min(image.width, x0 + kSide); ++x) {
          for (int c = 0; c < image.channels; ++c) to[c] = from[c];
          from += image.channels;
          to += way.along_x * image.channels;
        }
      }
  return out;
}

}  // namespace

template <class T>
ImageT<T> Oriented(ImageT<T> image, int orientation) {
  if (orientation <= 1 || orientation > 8) return image;
  return Turned(image, orientation);
}

template Image8 Oriented(Image8 image, int orientation);
template ImageF Oriented(ImageF image, int orientation);
template Image16 Oriented(Image16 image, int orientation);

Image8 TurnedOver(const Image8& image) { return Turned(image, 3); }
Image8 QuarterTurned(const Image8& image) { return Turned(image, 6); }

}  // namespace keypose
