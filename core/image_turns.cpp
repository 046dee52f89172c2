#include "core/image_turns.h"

#include <algorithm>

namespace keypose {

Image8 TurnedOver(const Image8& image) {
  Image8 turned(image.width, image.height, image.channels);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      std::copy_n(image.at(x, y), image.channels,
                  turned.at(image.width - 1 - x, image.height - 1 - y));
  return turned;
}

Image8 QuarterTurned(const Image8& image) {
  Image8 turned(image.height, image.width, image.channels);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      std::copy_n(image.at(x, y), image.channels, turned.at(image.height - 1 - y, x));
  return turned;
}

}  // namespace keypose
