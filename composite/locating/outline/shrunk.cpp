#include "composite/locating/outline/shrunk.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

/// What one pixel of the result covers along one axis.
struct Cover {
  int first;
  std::vector<float> weights;  // sum 1
};

std::vector<Cover> CoversOf(int from, int to) {
  std::vector<Cover> covers;
  const double factor = static_cast<double>(from) / to;
  for (int i = 0; i < to; ++i) {
    const double begin = i * factor, end = std::min((i + 1) * factor, static_cast<double>(from));
    Cover cover{static_cast<int>(begin), {}};
    for (int k = cover.first; k < from && k < end; ++k)
      cover.weights.push_back(static_cast<float>(
          (std::min(end, k + 1.0) - std::max(begin, static_cast<double>(k))) / factor));
    covers.push_back(cover);
  }
  return covers;
}

}  // namespace

Image8 Shrunk(const Image8& picture, int width, int height) {
  if (width == picture.width && height == picture.height) return picture;
  const std::vector<Cover> across = CoversOf(picture.width, width),
                           down = CoversOf(picture.height, height);
  const int channels = picture.channels;
  Image8 small(width, height, channels);
  ImageF rows(width, picture.height, channels);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < width; ++x)
      for (int k = 0; k < SizeOf(across[x].weights); ++k)
        for (int c = 0; c < channels; ++c)
          rows.at(x, y)[c] +=
              across[x].weights[k] * static_cast<float>(picture.at(across[x].first + k, y)[c]);
  for (int y = 0; y < height; ++y)
    for (int i = 0; i < width * channels; ++i) {
      float sum = 0.5f;
      for (int k = 0; k < SizeOf(down[y].weights); ++k)
        sum += down[y].weights[k] * rows.at(0, down[y].first + k)[i];
      small.at(0, y)[i] = static_cast<std::uint8_t>(std::min(255.0f, sum));
    }
  return small;
}

}  // namespace keypose::composite
