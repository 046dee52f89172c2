#include "fit/appearance/grey_pyramid.h"

#include <algorithm>

namespace keypose::fit {
namespace {

constexpr int kLeastSide = 8;

ImageF Luma(const Image8& picture) {
  ImageF grey(picture.width, picture.height, 1);
  const std::size_t count = grey.data.size();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* p = picture.data.data() + i * picture.channels;
    grey.data[i] = picture.channels < 3 ? p[0] : 0.299f * p[0] + 0.587f * p[1] + 0.114f * p[2];
  }
  return grey;
}

ImageF Halved(const ImageF& image) {
  ImageF half(image.width / 2, image.height / 2, 1);
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x)
      *half.at(x, y) = (*image.at(2 * x, 2 * y) + *image.at(2 * x + 1, 2 * y) +
                        *image.at(2 * x, 2 * y + 1) + *image.at(2 * x + 1, 2 * y + 1)) /
                       4;
  return half;
}

}  // namespace

GreyPyramid MakeGreyPyramid(const Image8& picture, int levels) {
  GreyPyramid pyramid{Luma(picture)};
  while (static_cast<int>(pyramid.size()) < levels &&
         std::min(pyramid.back().width, pyramid.back().height) >= 2 * kLeastSide)
    pyramid.push_back(Halved(pyramid.back()));
  return pyramid;
}

float SampleGrey(const ImageF& image, double x, double y) {
  x = std::clamp(x, 0.0, image.width - 1.0);
  y = std::clamp(y, 0.0, image.height - 1.0);
  const int x0 = std::min(static_cast<int>(x), image.width - 2),
            y0 = std::min(static_cast<int>(y), image.height - 2);
  const float u = static_cast<float>(x - x0), v = static_cast<float>(y - y0);
  const float *top = image.at(x0, y0), *low = image.at(x0, y0 + 1);
  return (1 - v) * ((1 - u) * top[0] + u * top[1]) + v * ((1 - u) * low[0] + u * low[1]);
}

}  // namespace keypose::fit
